"""Read and execute AP238 files of a given size: seconds of user CPU and peak memory.

    python benchmarks/stepnc_speed.py [--size-mb 10] [--kind lines|short|splines]

`lines` are long polylines (a CAM system's finishing passes), `short` many short toolpaths with their properties,
`splines` rational B-splines. Each size is read in a process of its own.
"""

import argparse
import math
import os
import resource
import subprocess
import sys
import tempfile
import time

import numpy as np

from cncgen.stepnc import read
from cncgen.stepnc.ap238.aim_file import AimFile
from cncgen.stepnc.part21 import Enumeration as E

HEAD = "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION((''),'2;1');\nFILE_NAME('','',(''),(''),'','','');\n"
SCHEMA = "FILE_SCHEMA(('INTEGRATED_CNC_SCHEMA'));\nENDSEC;\nDATA;\n"


def write(stream, size: int, kind: str) -> int:
    """Write an AP238 file of about `size` bytes; return the number of its motions."""
    stream.write(HEAD + SCHEMA)
    file = AimFile(stream)
    technology = file.method("MACHINING_TECHNOLOGY", "", "milling")
    item = file.measure("feed speed", 20.0, file.feed_unit)
    file.property(technology, "feedrate", "MACHINING_FEED_SPEED_REPRESENTATION", "feed speed", item)
    step = file.method("MACHINING_WORKINGSTEP", "ws")
    operation = file.method("FREEFORM_MILLING_OPERATION")
    file.add("MACHINING_OPERATION_RELATIONSHIP", "", "", step, operation)
    plan = file.method("MACHINING_WORKPLAN", "plan")
    file.relate("MACHINING_PROCESS_SEQUENCE_RELATIONSHIP", plan, step, 1)
    file.project(plan, "benchmark")
    count = {"lines": 1000, "short": 5, "splines": 8}[kind]
    paths = motions = 0
    position = np.zeros(3)
    while stream.tell() < size:
        t = paths * 0.37 + np.linspace(0.0, 3.0, count + 1)
        points = np.column_stack([50 * np.cos(t), 40 * np.sin(t), 3 * np.sin(5 * t)]).round(4)
        points[0] = position
        position = points[-1]
        refs = tuple(file.points(points))
        if kind == "splines":
            knots = tuple(float(k) for k in range(count - 1))
            curve = file.add_complex(
                ("B_SPLINE_CURVE", (3, refs, E("UNSPECIFIED"), E("F"), E("F"))),
                ("B_SPLINE_CURVE_WITH_KNOTS", ((4, *[1] * (count - 3), 4), knots, E("UNSPECIFIED"))),
                ("RATIONAL_B_SPLINE_CURVE", (tuple(1.0 + 0.5 * math.sin(k) for k in range(count + 1)),)),
            )
            motions += 1
        else:
            curve = file.add("POLYLINE", "", refs)
            motions += count
        path = file.method("MACHINING_TOOLPATH", "", "cutter location trajectory")
        paths += 1
        file.relate("MACHINING_TOOLPATH_SEQUENCE_RELATIONSHIP", operation, path, paths)
        file.property(path, "basic curve", "REPRESENTATION", "basic curve", curve)
        file.add("MACHINING_TECHNOLOGY_RELATIONSHIP", "", "", path, technology)
    stream.write("ENDSEC;\nEND-ISO-10303-21;\n")
    return motions


def measure(path: str) -> None:
    """Read and execute one file in this process and print the figures."""
    from pathlib import Path

    begin, wall = time.process_time(), time.perf_counter()
    program = read(Path(path), path)
    rows = sum(len(chunk) for chunk in program.chunks())
    cpu, wall = time.process_time() - begin, time.perf_counter() - wall
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    faults = [d.render() for d in program.diagnostics]
    print(
        f"{os.path.getsize(path) / 1e6:7.1f} MB  {rows:9d} rows  {cpu:6.2f} s CPU  {wall:6.2f} s  {peak:7.0f} MB",
        flush=True,
    )
    if faults:
        print("\n".join(faults[:5]))


def main() -> None:
    """Write a file and measure it in a fresh process."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size-mb", type=float, default=10.0)
    parser.add_argument("--kind", choices=("lines", "short", "splines"), default="lines")
    parser.add_argument("--measure", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.measure:
        measure(options.measure)
        return
    with tempfile.TemporaryDirectory() as folder:
        target = os.path.join(folder, "part.stp")
        with open(target, "w", encoding="ascii") as stream:
            write(stream, int(options.size_mb * 1e6), options.kind)
        subprocess.run([sys.executable, __file__, "--measure", target], check=True)


if __name__ == "__main__":
    main()

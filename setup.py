"""Build the parse tables of the grammars, codes of patterns, and the kernels: annotated Python in ``cncgen/kernels/``, compiled where a C compiler is.

Every extension is optional, so a machine without a compiler (or a build told so by ``CNCGEN_NO_COMPILE=1``)
installs the same files uncompiled; they run as plain Python, slowly, and `cncgen.kernels` warns once.
"""

import gc
import os
import runpy
import sys
from pathlib import Path

from setuptools import Extension, find_packages, setup

#: Loops do several numbers at once, and results stay those of the source: no sum is added in another order. Only that a
#: comparison or a root could raise a flag of the processor, which nobody reads, is not minded. A product is rounded before it is
#: added, on processors too that could do both at once. The last one lets a compiler ask at run time whether as many arrays
#: overlap as the passes of `least_time` have; others than GCC ignore it. Nobody steps through the C of a kernel: no symbols for it.
FLAGS = [
    "-O3",
    "-g0",
    "-fno-trapping-math",
    "-fno-math-errno",
    "-ffp-contract=off",
    "--param=vect-max-version-for-alias-checks=64",
]
#: Loops over the axes and states of a node have few turns, the same ones for two and for three axes: without them, 5 % less time.
UNROLLED = ["--param=max-completely-peeled-insns=2000", "--param=max-completely-peel-times=64"]
TUBE = ("cncgen.kernels.tube_step", "cncgen.kernels.tube_point", "cncgen.kernels.least_time_tube")
LINK = ["-Wl,-s"] if sys.platform == "linux" else []
#: What Cython writes for typed arrays, once for all kernels: as a part of each it was four fifths of the C.
SHARED = "cncgen.kernels._shared"
#: What calls and compares more than it computes is as fast with less optimising, which takes half of the time of compiling.
CALLING = ("cncgen.kernels.gcode_", SHARED)
#: What goes through each byte and block of a program: a twentieth of reading is saved for 2 s of compiling.
READING = {
    **dict.fromkeys(
        tuple(
            f"cncgen.kernels.gcode_{name}"
            for name in (
                "arithmetic",
                "instructions",
                "jumps",
                "lines",
                "parse",
                "rows",
                "run",
                "scan",
                "store",
            )
        ),
        "-O2",
    ),
    **dict.fromkeys(tuple(f"cncgen.kernels.gcode_{name}" for name in ("words", "motion", "frames")), "-O3"),
}
KERNELS = sorted(p for p in Path("cncgen/kernels").glob("*.py") if p.name != "__init__.py")


def kernel_extensions() -> list[Extension]:
    """One optional extension a kernel file, and one that they share, or none where compiling is switched off or Cython is missing."""
    if os.environ.get("CNCGEN_NO_COMPILE"):
        return []
    try:
        from Cython.Build import cythonize
    except ImportError:
        return []
    sources = {f"cncgen.kernels.{p.stem}": p.as_posix() for p in KERNELS}
    # Collecting garbage among the nodes of Cython's trees was a third of its time; they live as long as a file does.
    gc.set_threshold(200_000)
    extensions = [
        Extension(
            name,
            [path],
            extra_compile_args=FLAGS
            + [READING.get(name, "-O1")] * name.startswith(CALLING)
            + UNROLLED * (name in TUBE),
            extra_link_args=LINK,
        )
        for name, path in (sources | {SHARED: "cncgen/kernels/_shared.c"}).items()
    ]
    found = cythonize(
        extensions,
        language_level=3,
        nthreads=os.cpu_count() or 1,
        shared_utility_qualified_name=SHARED,
        compiler_directives={
            "boundscheck": False,
            "wraparound": False,
            "cdivision": True,
            "initializedcheck": False,
            "freethreading_compatible": False,
            # The one object that is pickled says how itself; what Cython writes for that was a seventh of the time of compiling.
            "auto_pickle": False,
        },
    )
    for extension in found:
        extension.optional = True  # Cython makes others of those that it takes, without it
    return found


# A process that Cython starts may import this file again.
if __name__ == "__main__":
    # pip asks for requirements and metadata before it builds: they need neither tables nor kernels.
    described = {"egg_info", "dist_info"} & set(sys.argv[1:])
    if not described:
        runpy.run_path("grammars/lalr.py")["write_all"]()
        runpy.run_path("grammars/patterns.py")["write"]()
    setup(
        packages=[*find_packages(include=["cncgen", "cncgen.*"]), "cncgen.grammars", "cncgen.programs"],
        ext_modules=[] if described else kernel_extensions(),
        options={"build_ext": {"parallel": os.cpu_count() or 1}},
    )

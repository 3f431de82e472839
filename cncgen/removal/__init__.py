"""Material removal: the material that a program cuts from a raw piece, and faults of the cut.

The stock is a height field: columns along Z on a square grid, so tools stand upright and cut from above. Rooms in the order in
which data passes them:

    record     what goes in and what comes out: `Cutter`, `Target`, `Removal`
    cutters    tools: from events of a toolpath, tables and options
    stock      raw pieces: boxes, cylinders, meshes; a grid of columns
    sweeps     toolpath rows as straight lines of the tip
    cutting    the loop over a program, by the kernel `cncgen.kernels.removal`
    findings   what is wrong, as diagnostics
    surfaces   the result as a mesh, and for pictures

docs/removal.md has the method.
"""

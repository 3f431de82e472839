"""Material removal: the material that a program cuts from a raw piece, and faults of the cut.

The stock is a height field where tools stand upright: columns along Z on a square grid. Where they lean, or the work stands otherwise
in several setups, it is three fields of dexels, along X, Y and Z. Of a lathe it is a row of rings along Z. Rooms in the order in
which data passes them:

    record     what goes in and what comes out: `Cutter`, `Target`, `Removal`
    cutters    tools: from events of a toolpath, tables and options
    stock      raw pieces: boxes, cylinders, meshes; a grid of columns
    sweeps     toolpath rows as straight lines of the tip
    poses      tips and axes of tools, from the axes of a machine
    dexels     raw pieces as dexels, and dexels as meshes
    walk       the loop over a program
    cutting    it over a height field, by the kernel `cncgen.kernels.removal`
    leaning    it over dexels, by the kernel `cncgen.kernels.dexel_sweeps`; meshes become dexels by `dexel_meshes`
    bars       it over a bar that turns
    findings   what is wrong, as diagnostics
    surfaces   the result as a mesh, and for pictures

docs/removal.md has the method.
"""

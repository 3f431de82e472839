"""The papers that this project recomputes: one module a paper, named by its authors and its year.

    yeh_sun_2008     saturation of the drives of a die bonder
    chen_hsu_2007    modified reference commands (undated; its latest reference is of 2007)
    jung_choi_2001   the stateline (undated; its latest reference is of 2001)
    tsai_2010        sharp corners, contour errors, and the appended paper on a flexure stage
    hsu_1999         ZPETC, cross coupling and task frame
    hsu_runs         its circles under its controllers
    tsai_stage       the appended paper's stage, its axes coupled
    printed          rows with their tolerances, and what became of them
    reproduction     `reproduce` and `draw_papers`, which load them by the names of `MODULES`
    planned          an example program, planned and sampled

Each paper's module has ``tables(programs)``, the printed values beside ours, and ``figures(programs)``, the figures redrawn.
docs/references.md lists the papers in full. `cncgen.cli.reproduce` alone calls this room.
"""

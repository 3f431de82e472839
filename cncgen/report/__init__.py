"""Reports for people: results as text, tables, pictures and pages. Nothing here changes a result.

    summary                     a plan: times, lengths, peaks of each axis (`differences`), `slow_places`, `line_times`
    page                        the HTML page of a plan: `cncgen/report/page`
    svg, notebook               pictures as SVG, and what a notebook shows
    comparing, comparison       strategies, interpolators and controllers side by side
    response, verdict           a simulation, and a verdict of `cncgen.verify`, as text
    identified, tuned           fits to a log, and tuned gains, with their margins
    plots, plot_data, drawing   pictures of a motion, by matplotlib
    tables                      what these share

`cncgen.cli` and `cncgen.pipeline` call them.
"""

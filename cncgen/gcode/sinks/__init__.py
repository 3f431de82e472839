"""Where canonical calls go: columns of a toolpath, text, a count, or the machine that `rs274` makes believe."""

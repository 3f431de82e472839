"""Where canonical calls go: columns of a toolpath, text, a count, or the imaginary machine of LinuxCNC's `rs274`."""

"""``python -m cncgen`` is the console command."""

from cncgen.cli import main

if __name__ == "__main__":
    main()

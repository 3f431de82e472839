"""Draw the figures of the servo pages from our own data: python docs/figures/servo.py."""

from pathlib import Path

from cncgen.papers.plots import paper_001, paper_004

HERE = Path(__file__).parent


def main() -> None:
    """Write controllers.png and inversion.png beside this file."""
    for name, wanted, figures in (
        ("controllers", "table1_contour", paper_004),
        ("inversion", "inversion", paper_001),
    ):
        for title, figure in figures(None):
            if title == wanted:
                figure.savefig(HERE / f"{name}.png", dpi=90)


if __name__ == "__main__":
    main()

"""Draw the figures of the servo pages from our own data: python docs/figures/servo.py."""

from pathlib import Path

from cncgen.papers import chen_hsu_2007, hsu_1999

HERE = Path(__file__).parent


def main() -> None:
    """Write controllers.png and inversion.png beside this file."""
    for name, wanted, paper in (
        ("controllers", "table1_contour", hsu_1999),
        ("inversion", "inversion", chen_hsu_2007),
    ):
        for title, figure in paper.figures():
            if title == wanted:
                figure.savefig(HERE / f"{name}.png", dpi=90)


if __name__ == "__main__":
    main()

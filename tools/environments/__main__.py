"""Writes descriptions and missing states of the catalog, and the pages of docs/environments."""

from pathlib import Path

from gym_extensions.catalog import descriptions
from gym_extensions.errors import reports_mistakes
from gym_extensions.files import write_bytes, write_text
from tools import argument_parser
from tools.environments import describe, pages, pictures, states


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Writes the descriptions, the pages, and the pictures if they are asked for."""
    parser = argument_parser("tools.environments", __doc__)
    out = "folder of the pages (default: %(default)s)"
    parser.add_argument("--out", type=Path, default=Path("docs/environments"), help=out)
    parser.add_argument("--pictures", action="store_true", help="also render the pictures (needs OpenGL)")
    options = parser.parse_args(argv)
    write_text(descriptions.PATH, describe.descriptions())
    descriptions.descriptions.cache_clear()
    recorded = states.update()
    texts = pages.pages(descriptions.descriptions())
    images = pictures.task_pictures() | pictures.map_pictures() if options.pictures else {}
    for name, text in texts.items():
        write_text(options.out / name, text)
    for name, image in images.items():
        write_bytes(options.out / "pictures" / name, image)
    print(
        f"{len(texts)} pages and {len(images)} pictures written to {options.out}; {recorded} tasks recorded."
    )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

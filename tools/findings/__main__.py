"""Writes docs/findings.md, docs/reproduction.md, their figures and the results of the README."""

from gym_extensions.errors import reports_mistakes
from tools import argument_parser
from tools.findings import findings, reproduction


@reports_mistakes
def main(argv: list[str] | None = None) -> int:
    """Writes both pages."""
    argument_parser("tools.findings", __doc__).parse_args(argv)
    findings.main()
    reproduction.main()
    return 0


if __name__ == "__main__":
    raise SystemExit(main())

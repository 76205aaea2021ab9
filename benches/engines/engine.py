"""What every engine's file in `engines/` has, and the words that they share.

    NAME              as a page calls it
    versions()        of the packages that compute, as one text
    SETTINGS          a list of Setting, its defaults first
    run(scene, setting)   times (s), theta (rad), theta_dot (rad/s) and the seconds of the stepping loop alone
"""

from dataclasses import dataclass, field


@dataclass(frozen=True)
class Setting:
    """`kind` is "default", "best" (by the engine's own documentation), or "more" (a point of the figure alone)."""

    name: str
    kind: str
    about: str
    source: str = ""
    options: dict = field(default_factory=dict)

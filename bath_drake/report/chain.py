"""The loop at a glance: its blocks, what flows between them, a figure for each."""

from dataclasses import dataclass
from html import escape

from bath_drake.report import style

_BOX_WIDTH, _BOX_HEIGHT, _GAP = 132, 58, 24
_TOP, _MIDDLE, _BOTTOM = 8, 112, 222
_COLUMNS = 8
_WIDTH = _COLUMNS * _BOX_WIDTH + (_COLUMNS - 1) * _GAP + 20
_HEIGHT = 316


@dataclass(frozen=True)
class ChainFigures:
    """One measured figure, as text, for each block of the loop."""

    camera: str
    camera_kind: str
    segmenter: str
    projector: str
    controller: str
    obstacles: str
    areas: str
    proof: str
    surface: str
    ik: str
    guard: str
    arm: str
    tracker: str


def draw_chain(figures: ChainFigures) -> str:
    """Returns the loop as an SVG element whose text can be selected."""
    column = [10 + k * (_BOX_WIDTH + _GAP) for k in range(_COLUMNS)]
    middle = _MIDDLE + _BOX_HEIGHT / 2
    blocks = [
        (0, _MIDDLE, "Depth camera", figures.camera_kind, figures.camera),
        (1, _MIDDLE, "Segmenter", "finds the back", figures.segmenter),
        (2, _MIDDLE, "Projector", "canonical space", figures.projector),
        (3, _MIDDLE, "Controller", "navigation function", figures.controller),
        (4, _MIDDLE, "Surface reference", "point and normal", figures.surface),
        (5, _MIDDLE, "Differential IK", "joint motion", figures.ik),
        (6, _MIDDLE, "Guard", "checks commands", figures.guard),
        (7, _MIDDLE, "Arm and nozzle", "Drake plant", figures.arm),
        (3, _TOP, "Virtual obstacles", "the learned skill", figures.obstacles),
        (2, _TOP, "Restricted areas", "seen by colour", figures.areas),
        (4, _TOP, "Certificate", "proof of the world", figures.proof),
        (4, _BOTTOM, "Tracker", "nozzle in canonical", figures.tracker),
    ]
    parts = [
        f'<svg class="chain" viewBox="0 0 {_WIDTH} {_HEIGHT}" role="img" '
        f'aria-label="The loop from camera to arm and back" '
        f'xmlns="http://www.w3.org/2000/svg">',
        "<defs>",
        _arrow_head("chain-ink", style.MUTED),
        _arrow_head("chain-back", style.REPRODUCTION),
        "</defs>",
    ]
    for k in range(_COLUMNS - 1):
        start = column[k] + _BOX_WIDTH
        parts.append(_line(f"M{start} {middle}H{column[k + 1] - 2}"))
    down = _TOP + _BOX_HEIGHT + 20
    x = column[3] + _BOX_WIDTH / 2
    parts.append(_line(f"M{x + 22} {down}V{_MIDDLE - 2}"))
    # Restricted areas come from the segmenter's image and go to the controller.
    x = column[1] + _BOX_WIDTH / 2
    top = _TOP + _BOX_HEIGHT / 2
    parts.append(_line(f"M{x} {_MIDDLE}V{top}H{column[2] - 2}"))
    elbow = column[2] + _BOX_WIDTH
    x = column[3] + 24
    parts.append(_line(f"M{elbow} {top}H{elbow + 13}V{_MIDDLE - 14}H{x}V{_MIDDLE - 2}"))
    # The world of both is proved, or the guard holds.
    parts.append(_line(f"M{column[3] + _BOX_WIDTH} {top}H{column[4] - 2}"))
    x = column[6] + _BOX_WIDTH / 2
    parts.append(_line(f"M{column[4] + _BOX_WIDTH} {top}H{x}V{_MIDDLE - 2}"))
    parts.append(
        f'<text x="{x + 8}" y="{top + 22}" class="note">holds unless proved</text>'
    )
    # Measured nozzle pose -> tracker -> controller closes the loop.
    low = _BOTTOM + _BOX_HEIGHT / 2
    x = column[7] + _BOX_WIDTH / 2 + 20
    start_y = _MIDDLE + _BOX_HEIGHT + 22
    end = column[4] + _BOX_WIDTH + 2
    parts.append(_line(f"M{x} {start_y}V{low}H{end}", back=True))
    x = column[3] + _BOX_WIDTH / 2
    parts.append(_line(f"M{column[4]} {low}H{x}V{start_y - 0}", back=True))
    # The camera sees what the arm did.
    x = column[7] + _BOX_WIDTH / 2 + 42
    floor = _HEIGHT - 6
    end_x = column[0] + _BOX_WIDTH / 2
    parts.append(_line(f"M{x} {start_y}V{floor}H{end_x}V{start_y}", dashed=True))
    parts += [_block(column[k], y, *text) for k, y, *text in blocks]
    parts.append(
        f'<text x="{end_x + 10}" y="{floor - 6}" class="note">'
        "the camera sees the person, and the robot's own pixels are left out</text>"
    )
    parts.append("</svg>")
    return "".join(parts)


def _arrow_head(name: str, colour: str) -> str:
    return (
        f'<marker id="{name}" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" '
        f'markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8z" fill="{colour}"/>'
        "</marker>"
    )


def _line(path: str, *, back: bool = False, dashed: bool = False) -> str:
    colour = style.REPRODUCTION if back else style.MUTED
    dash = ' stroke-dasharray="4 4"' if dashed else ""
    head = "chain-back" if back else "chain-ink"
    return (
        f'<path d="{path}" fill="none" stroke="{colour}" stroke-width="1.6"{dash} '
        f'stroke-linejoin="round" marker-end="url(#{head})"/>'
    )


def _block(x: float, y: float, title: str, role: str, figure: str) -> str:
    middle = x + _BOX_WIDTH / 2
    return (
        f'<rect x="{x}" y="{y}" width="{_BOX_WIDTH}" height="{_BOX_HEIGHT}" rx="8"/>'
        f'<text x="{middle}" y="{y + 24}" class="name">{escape(title)}</text>'
        f'<text x="{middle}" y="{y + 42}" class="role">{escape(role)}</text>'
        f'<text x="{middle}" y="{y + _BOX_HEIGHT + 15}" class="figure">'
        f"{escape(figure)}</text>"
    )

"""Writes films as animated SVG. SMIL animations move the points, so that no script is needed.
https://www.w3.org/TR/smil-animation/
"""

from __future__ import annotations

from html import escape

import numpy

from pkgen.plot.style import FONTS, GREY, INK

from .tracks import BESIDE, Track

_DISCRETE = ' calcMode="discrete"'
STILL = 0.05  # pixels: an element that moves less is static


def film(
    tracks: list[Track],
    size: tuple[int, int],
    seconds: float,
    title: str,
    texts: list[tuple[str, float, float]],
    times: list[tuple[str, float]] = (),
) -> str:
    """Returns the SVG, which repeats after `seconds`. `times` are texts of the clock, each with the
    time at which it appears, relative to the duration."""
    width, height = size
    body = []
    depth = [float(track.depth.mean()) for track in tracks]
    # A face of a solid vanishes when it turns away from the viewer. It must vanish from one frame
    # to the next, so positions are not interpolated between frames.
    solid = any(track.closed and track.fill and _moves(track.points) for track in tracks)
    beat = f'dur="{seconds:.6g}s" repeatCount="indefinite"{_DISCRETE if solid else ""}'
    for index in sorted(range(len(tracks)), key=lambda k: depth[k]):
        body.append(_element(tracks[index], height, beat))
    name = escape(title, quote=True)
    unit = min(size) / 720
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" role="img" '
        f'aria-label="{name}">\n<rect width="{width}" height="{height}" fill="#fff"/>\n'
        '<g fill="none" stroke-linecap="round" stroke-linejoin="round">\n'
        + "\n".join(body)
        + "\n</g>\n"
        + "\n".join(_text(text, x, height - y, unit) for text, x, y in texts)
        + _names(tracks, height, beat, unit)
        + _clock(times, seconds, height, unit)
        + "\n</svg>\n"
    )


def _text(text: str, x: float, y: float, unit: float) -> str:
    look = f'font-size="{22 * unit:.4g}" font-family="{FONTS}" fill="{GREY}"'
    return f'<text x="{x:.1f}" y="{y:.1f}" {look}>{escape(text)}</text>'


def _names(tracks: list[Track], height: int, beat: str, unit: float) -> str:
    """Returns the labels of discs; a label moves with its disc."""
    found = []
    for track in tracks:
        if track.label:
            points = _flipped(track.points, height)[:, 0]
            x, y = points[:, 0] + track.radius + BESIDE * unit, points[:, 1] - BESIDE * unit
            inner = _animate("x", [f"{v:.1f}" for v in x], beat, numpy.ptp(x) > STILL)
            inner += _animate("y", [f"{v:.1f}" for v in y], beat, numpy.ptp(y) > STILL)
            at = f'x="{x[0]:.1f}" y="{y[0]:.1f}"'
            found.append(f"<text {at}>{escape(track.label)}{inner}</text>")
    look = f'font-size="{16 * unit:.4g}" font-family="{FONTS}" fill="{GREY}"'
    return f"\n<g {look}>" + "\n".join(found) + "</g>" if found else ""


def _clock(times: list[tuple[str, float]], seconds: float, height: int, unit: float) -> str:
    """Returns one text element per time, which is visible until the next time: SMIL can hide a text
    but not change its words."""
    if not times:
        return ""
    found = []
    ends = [*(part for _, part in times[1:]), 1.0]
    for (text, begin), end in zip(times, ends, strict=True):
        cuts = [(0.0, "hidden"), (begin, "visible"), (end, "hidden")]
        cuts = [c for k, c in enumerate(cuts) if c[0] < 1 and not (k == 0 and begin == 0)]
        keys, values = ";".join(f"{c[0]:.5g}" for c in cuts), ";".join(c[1] for c in cuts)
        first = "visible" if begin == 0 else "hidden"  # initial state, for viewers without SMIL
        moves = (
            f'<animate attributeName="visibility" dur="{seconds:.6g}s" repeatCount="indefinite"'
            f'{_DISCRETE} keyTimes="{keys}" values="{values}"/>'
        )
        found.append(f'<text x="{20 * unit:.1f}" y="{height - 20 * unit:.1f}" '
                     f'visibility="{first}">{escape(text)}{moves}</text>')  # fmt: skip
    look = f'font-size="{22 * unit:.4g}" font-family="{FONTS}" fill="{INK}"'
    return f"\n<g {look}>" + "\n".join(found) + "</g>"


def _moves(points: numpy.ndarray) -> bool:
    return bool((numpy.ptp(numpy.nan_to_num(points), axis=0) > STILL).any())


def _element(track: Track, height: int, beat: str) -> str:
    look = f'stroke="{track.colour or "none"}" stroke-width="{track.width:.3g}"'
    if track.fill:
        look += f' fill="{track.fill}"'
    if track.alpha < 1:
        look += f' stroke-opacity="{track.alpha:g}"'
    if track.kind in ("trail", "graph"):
        return _trail(track, height, beat, look)
    points = _flipped(track.points, height)
    if track.kind == "disc":
        x, y = points[:, 0, 0], points[:, 0, 1]
        inner = _animate("cx", [f"{v:.1f}" for v in x], beat, numpy.ptp(x) > STILL)
        inner += _animate("cy", [f"{v:.1f}" for v in y], beat, numpy.ptp(y) > STILL)
        at = f'cx="{x[0]:.1f}" cy="{y[0]:.1f}" r="{track.radius:.1f}"'
        return f"<circle {at} {look}>{inner}</circle>"
    texts = [_path(frame, track.closed) for frame in points]
    moves = _moves(points)
    return f'<path d="{texts[0]}" {look}>{_animate("d", texts, beat, moves)}</path>'


def _trail(track: Track, height: int, beat: str, look: str) -> str:
    """Returns a trail: a static path with one dash that moves along it."""
    points = _flipped(track.points, height)[0]
    points = points[numpy.isfinite(points).all(axis=1)]
    along = numpy.concatenate([[0], numpy.linalg.norm(numpy.diff(points, axis=0), axis=1).cumsum()])
    total = float(along[-1]) + 1
    a, b = (along[numpy.minimum(track.span[:, k], len(along) - 1)] for k in (0, 1))
    dashes = [f"0 {x:.1f} {y - x:.1f} {total:.1f}" for x, y in zip(a, b, strict=True)]
    moving = _animate("stroke-dasharray", dashes, beat, True)
    look = look.replace("stroke-width", 'stroke-dasharray="' + dashes[0] + '" stroke-width')
    return f'<path d="{_path(points, False)}" {look}>{moving}</path>'


def _flipped(points: numpy.ndarray, height: int) -> numpy.ndarray:
    found = numpy.nan_to_num(points, copy=True)
    found[..., 1] = height - found[..., 1]
    return found


def _path(points: numpy.ndarray, closed: bool) -> str:
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + ("Z" if closed else "")


def _animate(name: str, values: list[str], beat: str, moves: bool) -> str:
    if not moves:
        return ""
    return f'<animate attributeName="{name}" {beat} values="{";".join(values)}"/>'

"""Elements of the page, as HTML."""

from __future__ import annotations

from html import escape

__all__ = ["Html", "tag"]


class Html(str):
    """Text that is escaped already."""

    __slots__ = ()


def tag(kind: str, /, *inside: str, **attributes: object) -> Html:
    """Write an element; ``class_`` and ``data_part`` are spelled as HTML does, texts are escaped."""
    given = [
        f' {key.rstrip("_").replace("_", "-")}="{escape(str(value))}"' for key, value in attributes.items()
    ]
    content = "".join(text if isinstance(text, Html) else escape(text) for text in inside)
    end = "" if kind == "input" else f"</{kind}>"
    return Html(f"<{kind}{''.join(given)}>{content}{end}")

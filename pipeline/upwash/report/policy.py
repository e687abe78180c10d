"""What a page may load: nothing but what stands in it."""

from __future__ import annotations

import base64
import hashlib


def policy(css: str, js: str, workers: str = "'none'") -> str:
    """Return a content security policy under which a page can load nothing from anywhere.

    Parameters
    ----------
    css, js : str
        Its style and its script, word for word.
    workers : str
        Where it may take workers from.
    """
    hashes = {
        name: base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        for name, text in (("css", css), ("js", js))
    }
    return (
        f"default-src 'none'; img-src data:; style-src 'sha256-{hashes['css']}'; script-src "
        f"'sha256-{hashes['js']}'; worker-src {workers}; base-uri 'none'; form-action 'none'"
    )

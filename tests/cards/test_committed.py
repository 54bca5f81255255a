"""The committed cards."""

import re
from pathlib import Path

CARDS = Path(__file__).parents[2] / "cards"


def test_the_links_of_the_committed_cards_lead_somewhere() -> None:
    pages = [*CARDS.glob("datasets/*.md"), *CARDS.glob("models/*.md")]
    links = [
        page.parent / place
        for page in pages
        for place in re.findall(r"\]\((?!http)([^)#]+)", page.read_text())
    ]
    assert len(links) > len(pages)
    assert not [place for place in links if not place.exists()]

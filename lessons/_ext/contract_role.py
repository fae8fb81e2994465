"""The role {contract}`key`: a number of contract.toml, with its unit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from contract import FILE, read
from docutils import nodes
from sphinx.util.docutils import SphinxRole

if TYPE_CHECKING:
    from sphinx.application import Sphinx


class ContractRole(SphinxRole):
    """Puts a number into the text; an unknown key is an error of the build."""

    def run(self) -> tuple[list[nodes.Node], list[nodes.system_message]]:
        """Return the number as text."""
        self.env.note_dependency(str(FILE))
        number = read().get(self.text)
        if number is None:
            message = self.inliner.reporter.error(
                f"contract.toml has no number {self.text!r}", line=self.lineno
            )
            return [self.inliner.problematic(self.rawtext, self.rawtext, message)], [message]
        return [nodes.inline(self.rawtext, number.text, classes=["contract"])], []


def setup(app: Sphinx) -> dict[str, Any]:
    """Tell Sphinx."""
    app.add_role("contract", ContractRole())
    return {"parallel_read_safe": True, "parallel_write_safe": True}

"""Who signs the report, and as what."""

from __future__ import annotations

from pydantic import Field, model_validator

from metrology.declaration.entry import Entry, Refusal, refuse
from metrology.declaration.scalars import Filled


class Signatory(Entry):
    """A person who signs the report in a role."""

    name: Filled = Field(description="Name, as the certificate of the person has it.", examples=["J. Doe"])
    function: Filled = Field(description="Function in the laboratory.", examples=["test engineer"])


class Signatures(Entry):
    """Who signs the report, in the order author, reviewer, approver; it is issued once all of them have signed."""

    author: Signatory | None = Field(
        None, description="Who wrote the report; signs first.", examples=["{name: J. Doe, function: test engineer}"]
    )
    reviewer: Signatory | None = Field(
        None, description="Who checked it; not the author.", examples=["{name: R. Roe, function: quality officer}"]
    )
    approver: Signatory | None = Field(
        None,
        description="Who releases it; signs last.",
        examples=["{name: M. Major, function: head of laboratory}"],
    )

    @model_validator(mode="after")
    def _plausible(self) -> Signatures:
        if self.author is None and self.reviewer is None and self.approver is None:
            raise refuse(Refusal((), "no role", "one role at least: author, reviewer, approver"))
        if self.author and self.reviewer and _same(self.author.name, self.reviewer.name):
            got = f"'{self.reviewer.name}', the author too"
            raise refuse(Refusal(("reviewer", "name"), got, "somebody else, as nobody reviews what he wrote himself"))
        return self

    def in_order(self) -> tuple[tuple[str, Signatory], ...]:
        """Roles that the campaign names, in the order in which they sign."""
        roles = (("author", self.author), ("reviewer", self.reviewer), ("approver", self.approver))
        return tuple((role, person) for role, person in roles if person is not None)


def _same(one: str, other: str) -> bool:
    return one.casefold().split() == other.casefold().split()

"""What no page is made of: a document of another kind, or one that a newer version wrote."""

import pytest

from drivegate_models.errors import InputError
from drivegate_reports.page.page import require_document


@pytest.mark.parametrize("schema", [1, 2])
def test_a_document_of_the_kind_and_an_earlier_or_this_schema_is_taken(schema: int) -> None:
    require_document({"kind": "comparison", "schema": schema}, "comparison", 2, "the comparison")


@pytest.mark.parametrize(
    ("document", "stated"),
    [
        ({}, "the document is of kind None, but must be of kind 'comparison'"),
        ({"kind": "check", "schema": 1}, "the document is of kind 'check', but must be of kind 'comparison'"),
        ({"kind": "comparison"}, "the comparison has the schema None, but this version reads up to 2"),
        ({"kind": "comparison", "schema": "1"}, "the comparison has the schema '1'"),
        (
            {"kind": "comparison", "schema": 3},
            "the comparison has the schema 3, but this version reads up to 2",
        ),
    ],
)
def test_any_other_is_refused_in_a_sentence(document: dict[str, object], stated: str) -> None:
    with pytest.raises(InputError) as refused:
        require_document(document, "comparison", 2, "the comparison")
    assert stated in str(refused.value)

"""A studio of a module's own, and a page in it."""

from collections.abc import Iterator

import pytest

from studio import Page, page, studio


@pytest.fixture(scope="module")
def address() -> Iterator[str]:
    with studio() as address:
        yield address


@pytest.fixture
def there(address: str) -> Iterator[Page]:
    with page(address) as there:
        yield there

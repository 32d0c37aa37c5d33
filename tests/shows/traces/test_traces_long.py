"""The synthetic laboratory of test_traces.py, 100 times at each noise, and behind a filter."""
import numpy as np
import pytest

from test_traces import computed, inside  # noqa: F401


@pytest.mark.parametrize("noise, highest", ((0.01, 0), (0.03, 0), (0.1, 0), (0.1, 0.6)))
def test_laboratory(computed, noise, highest):  # noqa: F811
    """Two errors hold 95 of 100 arrivals and speeds, by each way."""
    assert np.all(inside(computed, noise, 100, highest) >= 0.95)

"""Tables as data frames: pandas by default, polars or Arrow on request.

All tables are made of Arrow columns, and `pyarrow` is needed for each of them (`pip install "cxlab[tables]"`).
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from importlib import import_module
from typing import Any, Literal

from cxlab.errors import MachineError, UsageError

Frames = Literal["pandas", "polars", "arrow"]
FRAMES: tuple[Frames, ...] = ("pandas", "polars", "arrow")


def library(name: str) -> Any:
    """A package that tables need, imported when the first table is asked for."""
    try:
        return import_module(name)
    except ImportError as error:
        raise MachineError(
            f'{name} is not installed, and this table needs it: pip install "cxlab[tables]"'
            + (" polars" if name == "polars" else "")
        ) from error


def check_frames(frames: str) -> Frames:
    """The kind of data frames of that name."""
    for known in FRAMES:
        if frames == known:
            return known
    raise UsageError(f"frames: found '{frames}', expected one of pandas, polars and arrow")


def frame(table: Any, frames: Frames = "pandas") -> Any:
    """A `pyarrow.Table` as a data frame of that kind.

    Columns of pandas have the usual types of NumPy where each cell has a value. Whole numbers and truth values of
    which some are missing are `Int64` and `boolean`, so that an order stays 4 and does not become 4.0.
    """
    if frames == "arrow":
        return table
    if frames == "polars":
        return library("polars").from_arrow(table)
    pandas, arrow = library("pandas"), library("pyarrow")
    made = table.to_pandas()
    for name, column in zip(table.column_names, table.columns, strict=True):
        if column.null_count == 0:
            continue
        if arrow.types.is_integer(column.type):
            made[name] = column.to_pandas(types_mapper=lambda _: pandas.Int64Dtype())
        elif arrow.types.is_boolean(column.type):
            made[name] = column.to_pandas(types_mapper=lambda _: pandas.BooleanDtype())
    return made


def read(source: Any) -> Any:
    """Reads a table of the module (`_cxlab.TableSource`) as a `pyarrow.Table`."""
    arrow = library("pyarrow")
    try:
        return arrow.table(source)
    except arrow.lib.ArrowException:
        source.check()  # raises what is wrong, with file and line
        raise
    except OSError:
        source.check()
        raise


def from_rows(rows: Iterable[Mapping[str, Any]], columns: Sequence[str] = ()) -> Any:
    """Rows with names and values of JSON as a `pyarrow.Table`.

    `columns` come first, also where no row has them; the others follow as they come. A column has the one type of its
    values: whole, real, truth, text, or lists of these. One with values of several types is text.
    """
    cells: dict[str, list[Any]] = {name: [] for name in columns}
    length = 0
    for length, row in enumerate(rows, 1):
        for name, value in row.items():
            column = cells.setdefault(name, [])
            column += [None] * (length - 1 - len(column))
            column.append(value)
    for column in cells.values():
        column += [None] * (length - len(column))
    arrow = library("pyarrow")
    return arrow.table({name: _column(values, arrow) for name, values in cells.items()})


def _column(values: list[Any], arrow: Any) -> Any:
    kind = _type_of(values, arrow)
    if kind is not None:
        return arrow.array(values, kind)
    return arrow.array([None if value is None else as_text(value) for value in values], arrow.string())


def _type_of(values: Iterable[Any], arrow: Any) -> Any:
    """The type of Arrow that holds all values; None where only text does."""
    kinds = {type(value) for value in values if value is not None}
    if not kinds or kinds == {str}:
        return arrow.string()
    if kinds == {bool}:
        return arrow.bool_()
    if kinds == {int}:
        fits = all(-(2**63) <= value < 2**63 for value in values if value is not None)
        return arrow.int64() if fits else None
    if kinds <= {int, float}:
        return arrow.float64()
    if kinds == {list}:
        item = _type_of([item for value in values if value is not None for item in value], arrow)
        return None if item is None else arrow.list_(item)
    return None


def as_text(value: Any) -> str:
    """A text as it is, any other value of JSON as JSON."""
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)

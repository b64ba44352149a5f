# SPDX-License-Identifier: MIT
"""The extension. The modules of the package give its results their shape; use these."""
from typing import Any, Callable, Dict, List, Optional, Sequence, Tuple, Union

import numpy as np
import numpy.typing as npt

__version__: str

_Floats = npt.NDArray[np.float64]
_Text = Tuple[npt.NDArray[np.int32], List[str]]
#: Numbers, or codes (negative: missing) and the texts that they stand for.
_Column = Union[_Floats, _Text]
#: The same, or texts that were read already.
_Input = Union[_Floats, _Text, "Text"]
_Listener = Optional[Callable[[str, str, int, int], Any]]

class Text:
    def __len__(self) -> int: ...

class Table:
    @property
    def rows(self) -> int: ...
    @property
    def names(self) -> List[str]: ...
    def columns(self) -> List[Tuple[str, _Column]]: ...

class Catalogue:
    def __init__(self, models_directory: str) -> None: ...
    def models(self) -> List[Dict[str, Any]]: ...
    def formula(self, id: str) -> str: ...

class Fit:
    model: str
    formula: str
    response: str
    predictors: List[str]
    response_columns: List[str]
    columns: List[str]
    sub_models: List[Tuple[str, str]]
    random_text: str
    random_terms: List[Dict[str, Any]]
    variance: Dict[str, Any]
    method: str
    reml: bool
    observations: int
    excluded: int
    coefficient_names: List[str]
    estimate: _Floats
    covariance: _Floats
    standard_errors: _Floats
    degrees_of_freedom: _Floats
    t_values: _Floats
    p_values: _Floats
    parameter_values: List[Tuple[str, float]]
    sigma: float
    log_likelihood: float
    parameter_count: int
    aic: float
    aicc: float
    bic: float
    bic_groups: float
    r2_marginal: float
    r2_conditional: float
    population: Dict[str, float]
    conditional: Dict[str, float]
    converged: bool
    status: str
    verdict: str
    has_doubts: bool
    evidence: List[Dict[str, Any]]
    optima: List[Dict[str, Any]]
    seconds: float
    def to_json(self, indent: int = -1) -> str: ...
    @staticmethod
    def from_json(text: str, file: str = "") -> Fit: ...

class Library:
    @staticmethod
    def read(name_or_file: str, models: str) -> Library: ...
    @staticmethod
    def from_json(text: str) -> Library: ...
    @staticmethod
    def of(fits: Sequence[Fit]) -> Library: ...
    def models(self) -> List[Dict[str, Any]]: ...
    def to_json(self) -> str: ...
    def write(self, path: str) -> None: ...
    def predict(
        self, trees: Union[str, Table], catalogue: Catalogue, keywords: Dict[str, Any], listener: _Listener
    ) -> Dict[str, Any]: ...

def text(objects: npt.NDArray[np.object_]) -> Optional[Text]: ...
def table(rows: int, columns: Sequence[Tuple[str, _Input]]) -> Table: ...
def uses(formula: str, parameters: Sequence[str], random: str, variance: str) -> Tuple[List[str], List[str], str]: ...
def structure_names(texts: Sequence[str], columns: Sequence[str]) -> List[str]: ...
def with_computed(table: Table, names: Sequence[str], response: str) -> Tuple[Table, List[str]]: ...
def fit(
    table: Table,
    catalogue: Optional[Catalogue],
    texts: Dict[str, Any],
    options: Dict[str, Any],
    trace: bool,
    listener: _Listener,
) -> Fit: ...
def predict(fit: Fit, table: Table, keywords: Dict[str, Any], listener: _Listener) -> Dict[str, Any]: ...
def residuals(fit: Fit, table: Table) -> Dict[str, Any]: ...
def simulate(fit: Fit, table: Table, replicates: int, seed: int) -> Tuple[List[int], _Floats]: ...
def calibrate(fit: Fit, table: Table, seen_groups: str, threads: int) -> Dict[str, Any]: ...
def intervals(fit: Fit, table: Table, keywords: Dict[str, Any]) -> Dict[str, Any]: ...
def bootstrap(
    fit: Fit, table: Table, keywords: Dict[str, Any], refit: Dict[str, Any], listener: _Listener
) -> Dict[str, Any]: ...
def cross_validate(
    fit: Fit, table: Table, keywords: Dict[str, Any], refit: Dict[str, Any], listener: _Listener
) -> Dict[str, Any]: ...
def compare(fits: Sequence[Fit]) -> Dict[str, Any]: ...
def term_tests(fit: Fit) -> List[Tuple[str, int, float, float, float]]: ...
def structural_units(trees: Union[str, Table], keywords: Dict[str, Any], listener: _Listener) -> Dict[str, Any]: ...
def stand_summary(trees: Union[str, Table], keywords: Dict[str, Any], listener: _Listener) -> Dict[str, Any]: ...
def stand_growth(trees: Union[str, Table], keywords: Dict[str, Any], listener: _Listener) -> Dict[str, Any]: ...
def impute(
    trees: Union[str, Table], catalogue: Catalogue, keywords: Dict[str, Any], listener: _Listener
) -> Dict[str, Any]: ...
def study(
    trees: Union[str, Table], catalogue: Catalogue, keywords: Dict[str, Any], listener: _Listener
) -> Dict[str, Any]: ...
def grow(trees: Union[str, Table], models: str, keywords: Dict[str, Any], listener: _Listener) -> str: ...
def view(
    trees: Union[str, Table],
    models: str,
    page_template: str,
    page: str,
    keywords: Dict[str, Any],
    listener: _Listener,
) -> str: ...

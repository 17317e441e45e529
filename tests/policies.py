"""Small networks, written as ONNX files, and what they are fed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest

onnx = pytest.importorskip("onnx")
pytest.importorskip("onnxruntime")

Layer = tuple[np.ndarray, np.ndarray]  # weights of shape (in, out), and biases


def save_network(
    file: Path,
    layers: Sequence[Layer],
    *,
    activation: str = "Tanh",
    domain: str = "",
    metadata: Mapping[str, str] | None = None,
    inputs: Sequence[str] = ("obs",),
    shape: Sequence[int | str] | None = None,
    external: bool = False,
) -> Path:
    """Layers with an activation between them; a domain makes that an operator of nobody's."""
    helper, floats = onnx.helper, onnx.TensorProto.FLOAT
    nodes, weights, last = [], [], inputs[0]
    for k, (weight, bias) in enumerate(layers):
        for name, array in ((f"w{k}", weight), (f"b{k}", bias)):
            weights.append(onnx.numpy_helper.from_array(array.astype(np.float32), name))
        out = "actions" if k == len(layers) - 1 else f"x{k}"
        nodes.append(helper.make_node("Gemm", [last, f"w{k}", f"b{k}"], [out]))
        if out != "actions":
            nodes.append(helper.make_node(activation, [out], [f"y{k}"], domain=domain))
            last = f"y{k}"
    takes = shape or [1, layers[0][0].shape[0]]
    graph = helper.make_graph(
        nodes,
        "policy",
        [helper.make_tensor_value_info(name, floats, takes) for name in inputs],
        [helper.make_tensor_value_info("actions", floats, [1, layers[-1][0].shape[1]])],
        weights,
    )
    sets = [helper.make_opsetid("", 17)] + [helper.make_opsetid(domain, 1)] * bool(domain)
    model = helper.make_model(graph, opset_imports=sets, ir_version=8)
    helper.set_model_props(model, dict(metadata or {}))
    beside = {"location": f"{file.stem}.data", "size_threshold": 0} if external else {}
    onnx.save_model(model, str(file), save_as_external_data=external, **beside)
    return file


def constant(inputs: int, output: Sequence[float]) -> list[Layer]:
    """A network that says the same whatever it is fed."""
    return [(np.zeros((inputs, len(output))), np.asarray(output, dtype=float))]


def fitted(given: np.ndarray, wanted: np.ndarray, units: int, scale: float) -> list[Layer]:
    """Two layers that give what is wanted for what is given. Shapes (n, inputs), (n, outputs).

    The first is drawn, the second follows from least squares.
    """
    rng = np.random.default_rng(0)
    first = rng.normal(0.0, scale, (given.shape[1], units)), rng.normal(0.0, scale, units)
    hidden = np.column_stack([np.tanh(given @ first[0] + first[1]), np.ones(len(given))])
    ridge, none = 1e-4 * np.eye(units + 1), np.zeros((units + 1, wanted.shape[1]))
    second = np.linalg.lstsq(np.vstack([hidden, ridge]), np.vstack([wanted, none]), rcond=None)[0]
    return [first, (second[:-1], second[-1])]

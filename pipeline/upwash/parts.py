"""Kernels that other kernels call, compiled as parts of those: half of the time that numba would take.

numba improves each kernel and makes machine code of it, once for itself and again in each that calls it, and ours call
one another six deep.  A part is translated alone; what it is a part of is improved and made machine code once.  This
reaches into what numba does not promise to keep, so `upwash.kernel` uses it with the version that it was tried with.
"""

from __future__ import annotations

from typing import Any

from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import PassManager
from numba.core.typed_passes import DumpParforDiagnostics, InlineOverloads, NopythonRewrites
from numba.core.untyped_passes import (
    FindLiterallyCalls,
    InlineClosureLikes,
    InlineInlinables,
    LiteralPropagationSubPipelinePass,
    LiteralUnroll,
    MakeFunctionToJitFunction,
    RewriteDynamicRaises,
    WithLifting,
)

IDLE_PASSES = frozenset(
    (
        DumpParforDiagnostics,
        FindLiterallyCalls,
        InlineClosureLikes,
        InlineInlinables,
        InlineOverloads,
        LiteralPropagationSubPipelinePass,
        LiteralUnroll,
        MakeFunctionToJitFunction,
        NopythonRewrites,
        RewriteDynamicRaises,
        WithLifting,
    )
)
"""Passes of numba for closures, literals and expressions of arrays, which no kernel has."""


class _PartLibrary(JITCodeLibrary):
    """The code of a kernel as part of another: neither improved nor made machine code before it stands there."""

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True

    def get_pointer_to_function(self, name: str) -> int:
        """Return 0: nothing calls a part but what it is part of."""
        return 0

    @property
    def codegen(self) -> Any:
        """What would be told where the environment is: it is nowhere before the whole is compiled."""
        return self

    def set_env(self, name: str, environment: Any) -> None:
        """Do nothing."""


class _KernelCompiler(Compiler):
    """Compiles a kernel by numba's own passes, but for those that find nothing in kernels and take long."""

    def define_pipelines(self) -> list[PassManager]:
        """Return the passes."""
        (usual,) = super().define_pipelines()
        passes = PassManager("kernel")
        for one, what in usual.passes:
            if one not in IDLE_PASSES:
                passes.add_pass(one, what)
        passes.finalize()
        return [passes]


class _PartCompiler(_KernelCompiler):
    """Compiles a kernel that another one calls."""

    def _compile_core(self) -> Any:
        self.state.library = _PartLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        return super()._compile_core()


WHOLE: dict[str, Any] = {"pipeline_class": _KernelCompiler}
"""Options of a kernel that Python calls."""

PART: dict[str, Any] = {"pipeline_class": _PartCompiler, "no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Options of a kernel as part of another."""

// The machine's kernels of width 16 for a CPU without AVX-512: each two of eight lanes (pair.h).
#pragma once
#include "language/vm/executable.h"

namespace kinora::oracle {

// So that programs of this width run here, whatever the CPU.
language::MachineOptions optionsOfWidth(uint32_t width);

}  // namespace kinora::oracle

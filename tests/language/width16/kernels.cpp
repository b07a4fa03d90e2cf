#include "language/width16/kernels.h"

#include <cstdlib>

#include "simd/dispatch.h"

namespace kinora::language {

const KernelFunction* pairedArithmeticKernels(uint32_t width);
const KernelFunction* pairedMathKernels(uint32_t width);
const KernelFunction* pairedMixedKernels(uint32_t width);
const KernelFunction* pairedIntegerKernels(uint32_t width);
const KernelFunction* pairedMemoryKernels(uint32_t width);
const KernelFunction* pairedVectorKernels(uint32_t width);
const KernelFunction* pairedNoiseKernels(uint32_t width);
const KernelFunction* pairedColorKernels(uint32_t width);
const KernelFunction* pairedSplineKernels(uint32_t width);
const KernelFunction* pairedFusedKernels(uint32_t width);

}  // namespace kinora::language

namespace kinora::oracle {

namespace {

const language::KernelFunction* pairedKernels(language::Family family) {
  using language::Family;
  switch (family) {
    case Family::Arithmetic:
      return language::pairedArithmeticKernels(16);
    case Family::Math:
      return language::pairedMathKernels(16);
    case Family::Mixed:
      return language::pairedMixedKernels(16);
    case Family::Integer:
      return language::pairedIntegerKernels(16);
    case Family::Memory:
      return language::pairedMemoryKernels(16);
    case Family::Vector:
      return language::pairedVectorKernels(16);
    case Family::Noise:
      return language::pairedNoiseKernels(16);
    case Family::Color:
      return language::pairedColorKernels(16);
    case Family::Spline:
      return language::pairedSplineKernels(16);
    case Family::Fused:
      return language::pairedFusedKernels(16);
    case Family::Scalar:
    case Family::Count:
      return nullptr;
  }
  std::abort();  // a family without a file here
}

}  // namespace

language::MachineOptions optionsOfWidth(uint32_t width) {
  language::MachineOptions options;
  options.width = width;
  if (width == 16 && !cpuHasAvx512()) options.kernels16 = &pairedKernels;
  return options;
}

}  // namespace kinora::oracle

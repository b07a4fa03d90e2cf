#include "energy_table.h"

#include <kinora/math/microfacet.h>

namespace kinora::bench {
void energyTable(const float*& energy, const float*& mean) {
  static_assert(ReflectionEnergy::kMu == 32 && ReflectionEnergy::kRough == 32);
  const ReflectionEnergy& table = N_AVX2::reflectionEnergyTable();
  energy = &table.e[1][0][0];
  mean = table.mean[1];
}
}  // namespace kinora::bench

#define KINORA_KERNEL_FILE "shade/one_lane.cpp"
#include "shade/one_lane.h"
#include <kinora/simd/foreach_target.h>
#include <kinora/simd/tables.h>
#include <kinora/math/elementary.h>

KINORA_KERNELS_BEGIN
#if HWY_TARGET == HWY_AVX2
float exp1(float x) { return exp(Float<1>(x)).lane0(); }
float log1(float x) { return log(Float<1>(x)).lane0(); }
float tan1(float x) { return tan(Float<1>(x)).lane0(); }
float atan1(float x) { return atan(Float<1>(x)).lane0(); }
float atan21(float y, float x) { return atan2(Float<1>(y), Float<1>(x)).lane0(); }
float asin1(float x) { return asin(Float<1>(x)).lane0(); }
#endif
KINORA_KERNELS_END

#if HWY_ONCE
namespace kinora::shade::oneLane {
float exp(float x) { return N_AVX2::exp1(x); }
float log(float x) { return N_AVX2::log1(x); }
float tan(float x) { return N_AVX2::tan1(x); }
float atan(float x) { return N_AVX2::atan1(x); }
float atan2(float y, float x) { return N_AVX2::atan21(y, x); }
float asin(float x) { return N_AVX2::asin1(x); }
}  // namespace kinora::shade::oneLane
#endif

// PxrSurface's table of microfacet energies (GGX), for the scalar code beside it: 32 roughnesses by 32 cosines, and
// 32 means.
#pragma once
namespace kinora::bench {
void energyTable(const float*& energy, const float*& mean);
}

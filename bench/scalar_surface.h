// PxrSurface's evaluate() without glass and transmission, written as plain scalar C++: what width 1 of the wide
// source is held against. Not a second material: only core_surface.cpp calls it, after checking that both give the
// same values. GGX lobes, no anisotropy, no bump inputs.
#pragma once
#include <cstdint>

namespace kinora::bench {

struct ScalarSpecular {
  bool on = false, physical = false, doubleSided = false;
  float face[3] = {0, 0, 0}, edge[3] = {0, 0, 0}, ior[3] = {1, 1, 1}, extinction[3] = {0, 0, 0};
  float shape = 5, roughness = 0;
};
struct ScalarSurface {
  float diffuseColor[3] = {0, 0, 0}, diffuseGain = 1, diffuseRoughness = 0, diffuseExponent = 1;
  bool diffuseDoubleSided = false;
  ScalarSpecular specular[3];  // specular, rough specular, clear coat
  float coatThickness = 0, coatTint[3] = {0, 0, 0}, coatCompensation = 0, specularCompensation = 0;
  float fuzzGain = 0, fuzzColor[3] = {0, 0, 0}, fuzzConeAngle = 8;
  bool fuzzDoubleSided = false;
  const float *energy = nullptr, *energyMean = nullptr;  // energy_table.h
};
// n points, arrays as in a shading context; entering: not 0 where wo is outside.
struct ScalarPoints {
  uint32_t n;
  const float *N[3], *Ng[3], *wo[3], *wi[3];
  const uint32_t* entering;
  float *weight[3], *pdf, *pdfReverse;  // pdfReverse may be null
};
void evaluateScalar(const ScalarSurface& surface, const ScalarPoints& points);

}  // namespace kinora::bench

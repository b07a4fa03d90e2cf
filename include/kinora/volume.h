// The interface of a volume: fields over object space, for Volume "blobbydso:NAME" requests. Its parameters are the
// request's constants; its fields are what primvars of their names are to the medium that fills the request's bound.
#pragma once
#include <kinora/plugin.h>

namespace kinora {

struct VolumeBound {
  float low[3], high[3];  // object space; nothing is outside
};

// Where a field is asked for: points of object space, arrays of padded length.
struct VolumeArgs {
  uint32_t count;
  const float* P[3];
  const float* time;
  uint32_t field;   // index into VolumeTraits::fields
  float* value[3];  // out: value[0] alone for fields of one float
};

struct VolumeFunctions {
  void (*evaluate)(const void* volume, const VolumeArgs*);
};

struct VolumeField {
  const char* name;     // "density", "temperature", "Cs" ...
  uint32_t components;  // 1 or 3
};

struct VolumeTraits {
  const VolumeField* fields;
  uint32_t fieldCount;
  void (*bound)(const void* volume, VolumeBound*);
  // The largest and smallest value of a field (component by component) in a box: tracking needs majorants that hold.
  void (*extremes)(const void* volume, uint32_t field, const VolumeBound* box, float low[3], float high[3]);
};

// What a volume declares.
struct VolumePlugin {
  using Functions = VolumeFunctions;
  static constexpr Kind kKind = Kind::Volume;
  const char* help = "";
  ListOf<Param> params = {};
  SetUp setUp = {};
  ListOf<VolumeField> fields = {};
  void (*bound)(const void* volume, VolumeBound*) = nullptr;
  void (*extremes)(const void* volume, uint32_t field, const VolumeBound* box, float low[3], float high[3]) = nullptr;
  constexpr VolumeTraits traits() const { return {fields.data, fields.count, bound, extremes}; }
};

}  // namespace kinora

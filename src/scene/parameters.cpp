#include "scene/parameters.h"

namespace kinora::scene {

int componentsOf(ValueType t) {
  switch (t) {
    case ValueType::Color:
    case ValueType::Point:
    case ValueType::Vector:
    case ValueType::Normal:
      return 3;
    case ValueType::HPoint:
      return 4;
    case ValueType::Matrix:
    case ValueType::MPoint:
      return 16;
    default:
      return 1;
  }
}

const char* nameOf(ValueType t) {
  static const char* const kNames[] = {"float",  "int",         "string",       "color",         "point",
                                       "vector", "normal",      "hpoint",       "matrix",        "mpoint",
                                       "bxdf",   "lightfilter", "samplefilter", "displayfilter", "struct"};
  return kNames[int(t)];
}

const char* nameOf(StorageClass c) {
  static const char* const kNames[] = {"constant", "uniform", "varying", "vertex", "facevarying", "facevertex"};
  return kNames[int(c)];
}

bool isFloatBased(ValueType t) { return t == ValueType::Float || (t >= ValueType::Color && t <= ValueType::MPoint); }

size_t Parameter::size() const {
  if (!strings.empty()) return strings.size();
  return ints.empty() ? floats.size() : ints.size();
}

void ParameterList::set(Parameter p) {
  for (auto& held : list_)
    if (held->name == p.name) {
      held = std::make_shared<Parameter>(std::move(p));
      return;
    }
  list_.push_back(std::make_shared<Parameter>(std::move(p)));
}

const Parameter* ParameterList::find(std::string_view name) const {
  for (const auto& p : list_)
    if (p->name == name) return p.get();
  return nullptr;
}

Parameter* ParameterList::find(std::string_view name) {
  for (auto& p : list_)
    if (p->name == name) {
      if (p.use_count() > 1) p = std::make_shared<Parameter>(*p);
      return p.get();
    }
  return nullptr;
}

ParameterList::iterator ParameterList::begin() {
  for (auto& p : list_)
    if (p.use_count() > 1) p = std::make_shared<Parameter>(*p);
  return iterator(list_.begin());
}

bool ParameterList::erase(std::string_view name) {
  for (auto it = list_.begin(); it != list_.end(); ++it)
    if ((*it)->name == name) {
      list_.erase(it);
      return true;
    }
  return false;
}

float ParameterList::getFloat(std::string_view name, float fallback) const {
  const Parameter* p = find(name);
  if (!p || p->isReference) return fallback;
  if (!p->floats.empty()) return p->floats[0];
  if (!p->ints.empty()) return float(p->ints[0]);
  return fallback;
}

int ParameterList::getInt(std::string_view name, int fallback) const {
  const Parameter* p = find(name);
  if (!p || p->isReference) return fallback;
  if (!p->ints.empty()) return p->ints[0];
  if (p->floats.empty()) return fallback;
  // casting a value outside int's range is undefined; the largest float below 2^31 is 2147483520
  const float v = p->floats[0];
  if (!(v >= -2147483648.f)) return v == v ? INT32_MIN : fallback;
  return v > 2147483520.f ? INT32_MAX : int(v);
}

std::string ParameterList::getString(std::string_view name, std::string_view fallback) const {
  const Parameter* p = find(name);
  return p && !p->isReference && !p->strings.empty() ? p->strings[0] : std::string(fallback);
}

std::vector<float> ParameterList::getFloats(std::string_view name) const {
  const Parameter* p = find(name);
  if (!p || p->isReference) return {};
  if (!p->floats.empty()) return p->floats;
  return std::vector<float>(p->ints.begin(), p->ints.end());
}

size_t ParameterList::bytes() const {
  size_t n = list_.capacity() * sizeof(list_[0]);
  for (const auto& p : list_) {
    n += sizeof(Parameter) + p->name.capacity() + p->floats.capacity() * sizeof(float) +
         p->ints.bytes() + p->strings.bytes();
    for (const std::string& s : p->strings) n += s.capacity();
  }
  return n;
}

}  // namespace kinora::scene

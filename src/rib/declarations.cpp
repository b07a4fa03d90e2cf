#include "rib/declarations.h"

#include <charconv>
#include <utility>

namespace kinora::rib {

using scene::StorageClass;
using scene::ValueType;

namespace {

constexpr std::pair<std::string_view, StorageClass> kClasses[] = {
    {"constant", StorageClass::Constant},       {"uniform", StorageClass::Uniform},
    {"varying", StorageClass::Varying},         {"vertex", StorageClass::Vertex},
    {"facevarying", StorageClass::FaceVarying}, {"facevertex", StorageClass::FaceVertex}};

constexpr std::pair<std::string_view, ValueType> kTypes[] = {
    {"float", ValueType::Float},
    {"int", ValueType::Int},
    {"integer", ValueType::Int},
    {"string", ValueType::String},
    {"color", ValueType::Color},
    {"point", ValueType::Point},
    {"vector", ValueType::Vector},
    {"normal", ValueType::Normal},
    {"hpoint", ValueType::HPoint},
    {"matrix", ValueType::Matrix},
    {"mpoint", ValueType::MPoint},
    {"bxdf", ValueType::Bxdf},
    {"lightfilter", ValueType::LightFilter},
    {"samplefilter", ValueType::SampleFilter},
    {"displayfilter", ValueType::DisplayFilter},
    {"struct", ValueType::Struct},
    {"vstruct", ValueType::Struct},
};

// Section 2 of the RIB reference.
constexpr std::pair<const char*, const char*> kPredeclared[] = {
    {"P", "vertex point"},
    {"Pz", "vertex float"},
    {"Pw", "vertex hpoint"},
    {"N", "varying normal"},
    {"Np", "uniform normal"},
    {"Cs", "varying color"},
    {"Os", "varying color"},
    {"s", "varying float"},
    {"t", "varying float"},
    {"st", "varying float[2]"},
    {"width", "varying float"},
    {"constantwidth", "constant float"},
    {"height", "varying float"},
    {"fov", "uniform float"},
    {"origin", "uniform int[2]"},
    {"intensity", "uniform float"},
    {"lightcolor", "uniform color"},
    {"from", "uniform point"},
    {"to", "uniform point"},
    {"coneangle", "uniform float"},
    {"conedeltaangle", "uniform float"},
    {"beamdistribution", "uniform float"},
    {"amplitude", "uniform float"},
    {"background", "uniform color"},
    {"distance", "uniform float"},
    {"mindistance", "uniform float"},
    {"maxdistance", "uniform float"},
    {"Ka", "uniform float"},
    {"Kd", "uniform float"},
    {"Ks", "uniform float"},
    {"Kr", "uniform float"},
    {"roughness", "uniform float"},
    {"specularcolor", "uniform color"},
    {"texturename", "uniform string"},
    {"__instanceid", "uniform string"},
    {"__materialid", "uniform string"},
};

bool isSpace(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }

std::string_view takeWord(std::string_view& text) {
  while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
  size_t n = 0;
  while (n < text.size() && !isSpace(text[n]) && text[n] != '[') ++n;
  const std::string_view w = text.substr(0, n);
  text.remove_prefix(n);
  return w;
}

}  // namespace

Declarations::Declarations() {
  for (const auto& [name, text] : kPredeclared) declare(name, text);
}

std::optional<Declaration> Declarations::parse(std::string_view text, bool withName) {
  Declaration d;
  std::string_view w = takeWord(text);
  bool typed = false;
  while (!typed && !w.empty()) {
    bool known = false;
    for (const auto& [name, storage] : kClasses)
      if (w == name) {
        d.storage = storage;
        d.hasStorage = known = true;
      }
    if (w == "reference") d.isReference = known = true;
    for (const auto& [name, type] : kTypes)
      if (w == name) {
        d.type = type;
        typed = known = true;
      }
    if (!known) return std::nullopt;
    if (!typed) w = takeWord(text);
  }
  if (!typed) return std::nullopt;
  while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
  if (!text.empty() && text.front() == '[') {
    text.remove_prefix(1);
    while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
    d.arrayLength = 0;
    if (!text.empty() && text.front() != ']') {
      const auto r = std::from_chars(text.data(), text.data() + text.size(), d.arrayLength);
      constexpr int kMostArray = 1 << 24;
      if (r.ec != std::errc() || d.arrayLength < 0 || d.arrayLength > kMostArray) return std::nullopt;
      text.remove_prefix(size_t(r.ptr - text.data()));
    }
    while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
    if (text.empty() || text.front() != ']') return std::nullopt;
    text.remove_prefix(1);
    d.isArray = true;
  }
  while (!text.empty() && isSpace(text.front())) text.remove_prefix(1);
  while (!text.empty() && isSpace(text.back())) text.remove_suffix(1);
  if (withName == text.empty()) return std::nullopt;
  d.name = text;
  return d;
}

bool Declarations::declare(const std::string& name, std::string_view declaration) {
  auto d = parse(declaration, false);
  if (!d) return false;
  d->name = name;
  byName_[name] = std::move(*d);
  return true;
}

const Declaration* Declarations::find(const std::string& token) {
  if (const auto it = byName_.find(token); it != byName_.end()) return &it->second;
  if (const auto it = inline_.find(token); it != inline_.end()) return &it->second;
  auto d = parse(token, true);
  if (!d) return nullptr;
  constexpr size_t kMostRemembered = 4096;
  if (inline_.size() >= kMostRemembered) inline_.clear();
  return &(inline_[token] = std::move(*d));
}

}  // namespace kinora::rib

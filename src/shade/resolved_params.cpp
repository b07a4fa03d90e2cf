// What a node of the scene says for the parameters of its plug-in: ResolvedParams of material.h.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <set>

#include "base/text.h"
#include "plugin/types.h"
#include "shade/material.h"

namespace kinora::shade {

namespace {

bool isNumeric(Type t) { return t != Type::String && t != Type::Struct; }

// Whether a whole number is one of those that a parameter lists ("0 Color, 1 ColorBurn"), where it lists any.
bool isChoice(const Param& p, float value) {
  if (p.type != Type::Int || (p.flags & kParamArray)) return true;
  bool isListed = false, isDefaultListed = false;
  for (const char* at = p.choices; at && *at;) {
    char* end = nullptr;
    const long number = std::strtol(at, &end, 10);
    if (end == at) return true;
    isListed |= float(number) == value;
    isDefaultListed |= float(number) == p.value[0];
    at = std::strchr(end, ',');
    if (at) ++at;
  }
  return isListed || !isDefaultListed;
}

// Whether a word is one of those that a parameter lists ("linear|constant"), where it lists any.
bool isChoice(const Param& p, const std::string& word) {
  if (!p.choices || !std::strchr(p.choices, '|') || (p.flags & kParamArray) || word.empty()) return true;
  return ("|" + std::string(p.choices) + "|").find("|" + word + "|") != std::string::npos;
}

}  // namespace

ResolvedParams::ResolvedParams(const Descriptor& d, const scene::Node* node, Diagnostics& diagnostics) {
  values_.resize(d.paramCount);
  floats_.resize(d.paramCount);
  ints_.resize(d.paramCount);
  strings_.resize(d.paramCount);
  pointers_.resize(d.paramCount);
  std::set<std::string> used;
  for (uint32_t i = 0; i < d.paramCount; ++i) {
    const Param& p = d.params[i];
    const scene::Parameter* given = nullptr;
    if (node && !(p.flags & kParamOutput))
      for (const scene::Parameter& q : node->params)
        if (sameName(q.name, p.name)) given = &q;
    if (given) used.insert(given->name);
    ParamValue& v = values_[i];
    const uint32_t width = std::max(componentsOf(p.type), 1u);
    bool ok = false;
    if (given && given->isReference) {
      if (p.flags & (kParamNotConnectable | kParamOutput)) {
        diagnostics.warning("PARAM-NOT-CONNECTABLE", given->pos,
                            std::string(d.name) + "." + p.name + " of '" + node->handle + "' cannot be connected",
                            "its default is used");
      } else {
        v.connected = 1;
        v.given = 1;
        strings_[i] = given->strings;
      }
    } else if (given && p.type == Type::String) {
      if (!given->strings.empty()) {
        strings_[i] = given->strings;
        ok = true;
        // lists of other kinds may be examples
        if (d.kind == Kind::Pattern && !isChoice(p, given->strings[0]))
          diagnostics.warning("PARAM-CHOICE", given->pos,
                              std::string(d.name) + "." + p.name + " of '" + node->handle + "' is '" +
                                  given->strings[0].substr(0, 60) + "', which is none of its choices",
                              "it stands for nothing", std::string("there are ") + p.choices);
      }
    } else if (given && isNumeric(p.type)) {
      floats_[i] = given->floats;
      if (floats_[i].empty()) {
        floats_[i].assign(given->ints.begin(), given->ints.end());
        if (p.type == Type::Int) ints_[i] = given->ints;
      }
      bool finite = true;
      for (float f : floats_[i]) finite &= (f - f) == 0.f;
      if (!finite) {
        diagnostics.warning("PARAM-NOT-FINITE", given->pos,
                            std::string(d.name) + "." + p.name + " of '" + node->handle + "' is not a finite number",
                            "its default is used");
        floats_[i].clear();
      } else if (p.flags & kParamArray) {
        ok = true;
      } else if (floats_[i].size() >= width) {
        floats_[i].resize(width);
        ok = true;
      } else if (floats_[i].size() == 1 && width == 3) {
        floats_[i].assign(3, floats_[i][0]);
        ok = true;
      }
      if (ok && !isChoice(p, floats_[i][0])) {
        char said[32];
        std::snprintf(said, sizeof said, "%.9g", double(floats_[i][0]));
        diagnostics.warning("PARAM-CHOICE", given->pos,
                            std::string(d.name) + "." + p.name + " of '" + node->handle + "' is " + said +
                                ", which is none of its choices",
                            "its default is used", std::string("there are ") + p.choices);
        floats_[i].clear();
        ints_[i].clear();
        ok = false;
      } else if (!ok && finite)
        diagnostics.warning(
            "PARAM-TYPE", given->pos,
            std::string(d.name) + "." + p.name + " of '" + node->handle + "' has the wrong type or length",
            "its default is used");
    } else if (given && p.type != Type::Struct) {
      diagnostics.warning("PARAM-TYPE", given->pos,
                          std::string(d.name) + "." + p.name + " of '" + node->handle + "' has the wrong type",
                          "its default is used");
    }
    if (ok) v.given = 1;
    if (p.type == Type::String) {
      if (strings_[i].empty()) strings_[i] = {p.text};
      for (const std::string& s : strings_[i]) pointers_[i].push_back(s.c_str());
      v.strings = pointers_[i].data();
      v.count = uint32_t(pointers_[i].size());
    } else {
      if (floats_[i].empty()) {
        if (p.flags & kParamArray)
          floats_[i].assign(p.list, p.list + p.listCount);
        else
          floats_[i].assign(p.value, p.value + std::min(width, 3u));
      }
      if (v.connected)
        for (const std::string& s : strings_[i]) pointers_[i].push_back(s.c_str());
      v.strings = pointers_[i].data();
      v.floats = floats_[i].data();
      v.count = uint32_t(floats_[i].size());
    }
  }
  if (!node) return;
  for (const scene::Parameter& q : node->params) {
    if (used.count(q.name) || q.name.starts_with("__")) continue;
    diagnostics.warning("PARAM-UNKNOWN", q.pos,
                        std::string(d.name) + " '" + node->handle + "' has no parameter '" + q.name + "'", "ignored",
                        std::string("kinora plugins ") + d.name + " lists what it takes");
  }
}

}  // namespace kinora::shade

#include "film/light_paths.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace kinora::film {

namespace {

// States: 0 is "C"; 1 + e is "C<e>"; 5 + e is "C<e>[DS]+", e in RD, RS, TD, TS. A bit for each state a name takes.
struct Named { const char* name; uint16_t states; };
constexpr uint16_t first(int e) { return uint16_t(1u << (1 + e)); }
constexpr uint16_t more(int e) { return uint16_t(1u << (5 + e)); }
constexpr Named kNamed[] = {
    {"Ci", 0x1ff},
    {"beauty", 0x1ff},
    {"emissive", 1},
    {"directDiffuse", first(0)},
    {"indirectDiffuse", more(0)},
    {"directSpecular", first(1)},
    {"indirectSpecular", more(1)},
    {"diffuse", uint16_t(first(0) | more(0))},
    {"specular", uint16_t(first(1) | more(1))},
    {"subsurface", uint16_t(first(2) | more(2))},
    {"transmissive", uint16_t(first(3) | more(3))},
    {"direct", uint16_t(1 | first(0) | first(1) | first(2) | first(3))},
    {"indirect", uint16_t(more(0) | more(1) | more(2) | more(3))},
};

bool same(std::string_view a, std::string_view b) {
  return a.size() == b.size() && std::equal(a.begin(), a.end(), b.begin(), [](char x, char y) {
           return std::tolower(static_cast<unsigned char>(x)) == std::tolower(static_cast<unsigned char>(y));
         });
}

// The light path expressions of the standard set, spaces removed, as scenes write them.
struct Expression { const char* text; const char* name; };
constexpr Expression kExpressions[] = {
    {"C[DS]*[<L.>O]", "Ci"},
    {"C[<L.>O]", "emissive"},
    {"C<RD>[<L.>O]", "directDiffuse"},
    {"C<RD>[DS]+[<L.>O]", "indirectDiffuse"},
    {"C<RS>[<L.>O]", "directSpecular"},
    {"C<RS>[DS]+[<L.>O]", "indirectSpecular"},
    {"C<TD>[DS]*[<L.>O]", "subsurface"},
    {"C<TS>[DS]*[<L.>O]", "transmissive"},
};

const Named* lookup(std::string_view source) {
  for (const char* prefix : {"color ", "lpe:"})
    if (source.starts_with(prefix)) source.remove_prefix(std::string_view(prefix).size());
  for (const Expression& e : kExpressions)
    if (source == e.text) source = e.name;
  for (const Named& n : kNamed)
    if (same(source, n.name)) return &n;
  return nullptr;
}

}  // namespace

bool LightPaths::knows(std::string_view source) { return lookup(source) != nullptr; }

LightPaths::LightPaths(const std::vector<std::string>& sources, bool needSplit) : outputs_(kStates) {
  split_ = needSplit;
  for (size_t i = 0; i < sources.size(); ++i) {
    const Named* n = lookup(sources[i]);
    if (!n) continue;
    // does this name tell the four events apart?
    const uint16_t f = (n->states >> 1) & 15, m = (n->states >> 5) & 15;
    if ((f != 0 && f != 15) || (m != 0 && m != 15)) split_ = true;
    for (uint32_t s = 0; s < kStates; ++s)
      if (n->states >> s & 1) outputs_[s].push_back(uint16_t(i));
  }
  next_.resize(kStates * kEvents);
  for (uint32_t s = 0; s < kStates; ++s)
    for (uint32_t e = 0; e < kEvents; ++e)
      next_[s * kEvents + e] = uint32_t(s == 0 ? 1 + e : s <= 4 ? s + 4 : s);
}

uint16_t LightPaths::event(uint32_t lobeFlags) const {
  if (!split_) return 0;
  return uint16_t((lobeFlags & kLobeTransmit ? 2 : 0) | (lobeFlags & kLobeSpecular ? 1 : 0));
}

const char* LightPaths::eventName(uint16_t event) {
  static constexpr std::array<const char*, 4> kNames{"RD", "RS", "TD", "TS"};
  return event < 4 ? kNames[event] : "?";
}

}  // namespace kinora::film

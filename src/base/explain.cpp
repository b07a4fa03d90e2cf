#include "base/explain.h"

#include <algorithm>
#include <cctype>

namespace kinora {

namespace {

bool sameWithoutCase(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](unsigned char x, unsigned char y) { return std::toupper(x) == std::toupper(y); });
}

}  // namespace

void Explanations::add(std::span<const Explanation> table) { tables_.push_back(table); }

const Explanation* Explanations::find(std::string_view code) const {
  const Explanation* family = nullptr;
  for (const auto& table : tables_)
    for (const Explanation& e : table) {
      if (sameWithoutCase(e.code, code)) return &e;
      if (e.code.ends_with('-') && code.size() > e.code.size() &&
          sameWithoutCase(e.code, code.substr(0, e.code.size())) && (!family || e.code.size() > family->code.size()))
        family = &e;
    }
  return family;
}

std::vector<std::string_view> Explanations::codes() const {
  std::vector<std::string_view> all;
  for (const auto& table : tables_)
    for (const Explanation& e : table) all.push_back(e.code);
  std::sort(all.begin(), all.end());
  return all;
}

}  // namespace kinora

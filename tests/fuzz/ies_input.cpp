#include "fuzz/ies_input.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "light/ies_profile.h"

namespace kinora::fuzz {

namespace {

[[noreturn]] void fail(const char* what) {
  std::fprintf(stderr, "IES profile: %s\n", what);
  std::abort();
}

bool isRising(const std::vector<float>& angles) {
  return std::adjacent_find(angles.begin(), angles.end(), [](float a, float b) { return !(a < b); }) == angles.end();
}

}  // namespace

size_t readIesInput(std::string_view text) {
  light::IesProfile p;
  const light::IesError error = light::readIes(text, p);
  if (error.line != 0) {
    if (error.what.empty()) fail("refused without a message");
    if (error.line > 1 + size_t(std::count(text.begin(), text.end(), '\n')) + 1) fail("a line that is none");
    return 1;
  }
  if (!error.what.empty()) fail("a message without a line");
  if (p.vertical.size() < 2 || p.horizontal.empty()) fail("no angles");
  if (p.candela.size() != p.vertical.size() * p.horizontal.size()) fail("the table has another size");
  if (!isRising(p.vertical) || !isRising(p.horizontal)) fail("angles that do not rise");
  const bool isC = p.type == light::IesType::C;
  const auto within = [](const std::vector<float>& a, float least, float most) {
    return a.front() >= least && a.back() <= most;
  };
  if (!within(p.vertical, isC ? 0.f : -90.f, isC ? 180.f : 90.f)) fail("vertical angles out of range");
  if (!within(p.horizontal, isC ? 0.f : -90.f, isC ? 360.f : 90.f)) fail("horizontal angles out of range");
  if (isC && p.horizontal.size() > 1 && (p.horizontal.front() != 0 || p.horizontal.back() != 360))
    fail("horizontal angles that do not go all around");
  for (const float c : p.candela)
    if (!(c >= 0) || !std::isfinite(c)) fail("a value that is no intensity");
  if (std::all_of(p.candela.begin(), p.candela.end(), [](float c) { return c == 0; })) fail("it gives no light");
  return 0;
}

}  // namespace kinora::fuzz

// The programs of tests/language/programs: each gives what its text says, at every width, optimised or not, at
// several numbers of points, with the same bits; its parameters as constants, as uniform and as varying inputs, and
// mixed, so that folding and the kernels for each kind of operand run.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <regex>

#include "language/expression.h"
#include "language/program_file.h"
#include "language/program_runner.h"
#include "language/vm/strings.h"
#include "language/vm/test_runner.h"
#include "language/width16/kernels.h"

namespace kinora::oracle {
namespace {

using namespace language;
using language::testing::Points;

constexpr uint32_t kPoints = 1000;

const std::vector<ProgramFile>& programs() {
  static const std::vector<ProgramFile> all = readPrograms();
  return all;
}

// Of the parameters: which one is how.
enum class Road : uint8_t { Folded, Uniform, Varying };

bool isInputParam(const Symbol& s) {
  return s.kind == SymbolKind::Param && !s.hasInitCode && componentsOf(s.type.base) > 0 && s.type.arrayLength >= 0;
}

// The group with each parameter on its road. `varying` keeps what the points are given.
struct Prepared {
  ShaderGroup group;
  std::vector<std::string> varying;  // "layer.parameter"
};
Prepared prepared(const ProgramFile& p, const std::function<Road(size_t number)>& road) {
  Prepared r{p.group, {}};
  size_t number = 0;
  for (Layer& layer : r.group.layers)
    for (const Symbol& s : layer.shader->symbols) {
      if (!isInputParam(s)) continue;
      const bool isConnected =
          std::any_of(p.group.connections.begin(), p.group.connections.end(), [&](const Connection& c) {
            return c.toLayer == layer.name && c.to.substr(0, c.to.find('[')) == s.name.substr(0, s.name.find('.'));
          });
      if (isConnected) continue;
      switch (road(number++)) {
        case Road::Folded:
          break;
        case Road::Uniform:
          layer.settings.push_back({s.name, s.type, s.values});
          break;
        case Road::Varying:
          r.varying.push_back(layer.name + "." + s.name);
          break;
      }
    }
  const auto varying = r.varying;
  r.group.perPoint = [varying](const Layer& layer, const Symbol& s) {
    const bool is = std::find(varying.begin(), varying.end(), layer.name + "." + s.name) != varying.end();
    return PerPoint{is, is && (s.type.base == Base::Float || isTriple(s.type.base))};
  };
  return r;
}

const Points& pointsOf(uint32_t n) {
  static std::map<uint32_t, std::unique_ptr<Points>> all;
  auto& p = all[n];
  if (!p) p = std::make_unique<Points>(n);
  return *p;
}

Variables variablesOf(const ProgramFile& p, uint32_t i) {
  const Points& points = pointsOf(kPoints);
  const auto at = [&](const char* name) { return double(points.arrays.at(name)[i]); };
  Variables all = {{"u", {at("u")}},
                   {"v", {at("v")}},
                   {"P", {at("Px"), at("Py"), at("Pz")}},
                   {"N", {at("Nx"), 0, at("Nz")}},
                   {"time", {at("time")}},
                   {"step", {double(Points::kStep)}},
                   {"i", {double(i)}}};
  for (const auto& shader : p.shaders)
    for (const Symbol& s : shader->symbols)
      if (isInputParam(s) && s.type.base != Base::String) {
        Numbers& n = all[s.name];
        n.assign(s.values.floats.begin(), s.values.floats.end());
        if (s.type.base == Base::Int) n.assign(s.values.ints.begin(), s.values.ints.end());
      }
  return all;
}

std::string shortened(double d) {
  char text[64];
  std::snprintf(text, sizeof text, "%g", d);
  return text;
}
// {formula} in a text becomes its value
std::string filled(const std::string& text, const Variables& variables) {
  std::string out;
  for (size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '{') {
      out += text[i];
      continue;
    }
    const size_t end = text.find('}', i);
    out += shortened(evaluate(text.substr(i + 1, end - i - 1), variables)[0]);
    i = end;
  }
  return out;
}

// What the text of a program says against what it gave.
std::string difference(const ProgramFile& p, const Ran& ran) {
  std::vector<std::string> messages;
  std::vector<uint8_t> isTold(p.said.size());
  // what does not depend on the point is computed once
  static const std::regex kVaries("(^|[^A-Za-z_0-9])(u|v|P|N|i)($|[^A-Za-z_0-9])");
  std::vector<Numbers> known(p.expected.size());
  for (size_t k = 0; k < known.size(); ++k)
    if (!p.expected[k].isText && !std::regex_search(p.expected[k].formula, kVaries))
      known[k] = evaluate(p.expected[k].formula, variablesOf(p, 0));
  const Variables first = variablesOf(p, 0);
  const bool varies =
      !p.said.empty() || std::any_of(known.begin(), known.end(), [](const Numbers& n) { return n.empty(); });
  for (uint32_t i = 0; i < kPoints; ++i) {
    const Variables here = varies ? variablesOf(p, i) : Variables(), &variables = varies ? here : first;
    for (const Expected& e : p.expected) {
      const std::string place =
          p.name + ":" + std::to_string(e.line) + ": " + e.output + " of point " + std::to_string(i) + " is ";
      Base base = Base::Float;
      for (const Symbol& s : p.shaders.back()->symbols)
        if (s.name == e.output) base = s.type.base;
      const auto bits = [&](float f) {
        int32_t x;
        std::memcpy(&x, &f, 4);
        return x;
      };
      if (e.isText) {
        const std::string& got = stringOf(bits(ran.values.at(e.output)[i]));
        const std::string want = filled(e.text, variables);
        if (got != want) return place + "\"" + got + "\" instead of \"" + want + "\"";
        continue;
      }
      const Numbers& constant = known[size_t(&e - p.expected.data())];
      Numbers want = constant.empty() ? evaluate(e.formula, variables) : constant;
      const size_t n = ran.values.contains(e.output) ? 1 : [&] {
        size_t k = 0;
        while (ran.values.contains(e.output + "." + std::to_string(k))) ++k;
        return k;
      }();
      if (n == 0) return place + "missing";
      if (want.size() == 1) want.resize(n, want[0]);
      if (want.size() != n)
        return place + std::to_string(n) + " numbers, expected are " + std::to_string(want.size());
      for (size_t k = 0; k < n; ++k) {
        const float f = ran.values.at(n == 1 ? e.output : e.output + "." + std::to_string(k))[i];
        const bool isInt = base == Base::Int;
        const double got = isInt ? double(bits(f)) : double(f);
        const double tolerance = e.tolerance >= 0 ? e.tolerance : isInt ? 0 : 1e-6;
        if (float(got) == float(want[k]) || (std::isnan(got) && std::isnan(want[k]))) continue;
        if (std::isfinite(want[k]) && std::fabs(got - want[k]) <= tolerance * std::max(1.0, std::fabs(want[k])))
          continue;
        char text[128];
        std::snprintf(text, sizeof text, "%.9g (component %zu) instead of %.9g", got, k, want[k]);
        return place + text;
      }
    }
    for (size_t k = 0; k < p.said.size(); ++k) {
      const Said& s = p.said[k];
      if (isTold[k] || (!s.when.empty() && evaluate(s.when, variables)[0] == 0)) continue;
      if (s.isOnce) isTold[k] = 1;
      messages.push_back(filled(s.text, variables));
    }
  }
  for (size_t k = 0; k < std::max(messages.size(), ran.messages.size()); ++k) {
    const std::string got = k < ran.messages.size() ? ran.messages[k].text : "nothing",
                      want = k < messages.size() ? messages[k] : "nothing";
    if (got != want)
      return p.name + ": message " + std::to_string(k) + " is \"" + got + "\" instead of \"" + want + "\"";
  }
  return {};
}

// The first n points of `all` must be `few`, bit by bit.
std::string bitsDifferAt(const Ran& all, const Ran& few, uint32_t n) {
  for (const auto& [name, values] : few.values)
    for (uint32_t i = 0; i < n; ++i)
      if (std::memcmp(&values[i], &all.values.at(name)[i], 4) != 0)
        return name + " of point " + std::to_string(i) + ": " + std::to_string(values[i]) + " instead of " +
               std::to_string(all.values.at(name)[i]);
  return n == kPoints && !(few.messages == all.messages) ? "messages differ" : "";
}

// One way of giving parameters, at all widths and numbers of points.
bool check(const ProgramFile& p, const char* roadName, const std::function<Road(size_t)>& road, bool isThorough,
           const Ran* sibling, Ran& reference) {
  const Prepared group = prepared(p, road);
  bool isFirst = true;
  for (const bool optimised : {false, true})
    for (const uint32_t width : {1u, 4u, 8u, 16u}) {
      if (!isThorough && (width != 8 || !optimised)) continue;
      MachineOptions options = optionsOfWidth(width);
      options.optimise = optimised;
      options.blockPoints = width == 4 ? 64 : 0;
      options.iterationLimit = 2000;
      const std::string how =
          p.name + ", " + roadName + ", width " + std::to_string(width) + (optimised ? ", optimised" : "");
      std::string error;
      const auto program = compileGroup(group.group, options, error);
      if (!program) {
        ADD_FAILURE() << how << ": " << error;
        return false;
      }
      for (const uint32_t n : {kPoints, 1u, 7u, 16u, 40u}) {
        if (n != kPoints && !isThorough) continue;
        Ran ran = runOnce(*program, group.group, pointsOf(n));
        if (isFirst) {
          isFirst = false;
          reference = std::move(ran);
          if (sibling && p.isAlike) {  // which was compared with the text
            if (const std::string d = bitsDifferAt(*sibling, reference, kPoints); !d.empty())
              return ADD_FAILURE() << how << " and folded: " << d, false;
          } else if (const std::string d = difference(p, reference); !d.empty()) {
            return ADD_FAILURE() << d << " (" << how << ")", false;
          }
          continue;
        }
        if (const std::string d = bitsDifferAt(reference, ran, n); !d.empty()) {
          ADD_FAILURE() << how << ", " << n << " points: " << d << "\n" << program->listing();
          return false;
        }
      }
    }
  return true;
}

TEST(Programs, GiveWhatTheirTextSays) {
  EXPECT_GE(programs().size(), 250u);
  const char* only = std::getenv("KINORA_PROGRAM");
  for (const ProgramFile& p : programs()) {
    if (only && p.name.find(only) == std::string::npos) continue;
    if (!p.wrong.empty()) {
      ADD_FAILURE() << p.name << ": " << p.wrong;
      continue;
    }
    size_t parameters = 0;
    prepared(p, [&](size_t) {
      ++parameters;
      return Road::Folded;
    });
    Ran folded, other;
    const Ran* sibling = nullptr;
    if (p.isFolded) {
      if (!check(
              p, "folded", [](size_t) { return Road::Folded; }, true, nullptr, folded))
        continue;
      sibling = &folded;
    }
    if (parameters == 0) continue;
    if (p.isUniform && !check(
                           p, "uniform", [](size_t) { return Road::Uniform; }, true, sibling, other))
      continue;
    if (p.isVarying && !check(
                           p, "varying", [](size_t) { return Road::Varying; }, true, sibling, other))
      continue;
    if (p.isUniform && p.isVarying && parameters > 1)
      for (size_t k = 0; k < std::min<size_t>(parameters, 6); ++k)
        if (!check(
                p, "one varies", [&](size_t i) { return i == k ? Road::Varying : Road::Uniform; }, false, sibling,
                other) ||
            !check(
                p, "one is uniform", [&](size_t i) { return i == k ? Road::Uniform : Road::Varying; }, false, sibling,
                other))
          break;
  }
}

TEST(Programs, DerivativesAreThoseOfDifferences) {
  constexpr float h = 1.f / 512;
  size_t count = 0;
  for (const ProgramFile& p : programs()) {
    if (p.differences.empty() || !p.wrong.empty()) continue;
    ++count;
    std::string error;
    const auto program = compileGroup(p.group, {}, error);
    ASSERT_TRUE(program) << p.name << error;
    const auto at = [&](float du, float dv) { return runOnce(*program, p.group, Points(kPoints, du, dv), du, dv); };
    const Ran here = at(0, 0), right = at(h, 0), left = at(-h, 0), up = at(0, h), down = at(0, -h);
    for (const Difference& d : p.differences)
      for (const auto& [name, values] : here.values) {
        if (name != d.of && !name.starts_with(d.of + ".")) continue;
        const std::string tail = name.substr(d.of.size());
        for (uint32_t i = 0; i < kPoints; ++i)
          for (const bool alongX : {true, false}) {
            const auto &a = (alongX ? right : up).values.at(name), &b = (alongX ? left : down).values.at(name);
            const double slope = (double(a[i]) - double(b[i])) / (2 * h),
                         got = double(here.values.at((alongX ? d.x : d.y) + tail)[i]) / Points::kStep;
            if (std::fabs(got - slope) <= d.tolerance * std::max(1.0, std::fabs(slope))) continue;
            ADD_FAILURE() << p.name << ": " << (alongX ? d.x : d.y) << tail << " of point " << i << " is " << got
                          << " instead of " << slope << " a unit";
            goto next;
          }
      next:;
      }
  }
  EXPECT_GE(count, 7u);
}

}  // namespace
}  // namespace kinora::oracle

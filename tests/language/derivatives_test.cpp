// Derivatives of every library function, along each of its arguments: a program for each overload, made from the
// compiler's table, against central differences of the same program at shifted points. What drops derivatives must
// give exactly 0. Points beside a kink (differences to the left and to the right disagree) decide nothing.
#include <gtest/gtest.h>

#include <cmath>

#include "language/front/builtins.h"
#include "language/front/compile.h"
#include "language/program_runner.h"
#include "language/width16/kernels.h"

namespace kinora::oracle {
namespace {

using namespace language;
using language::testing::Points;

bool isNumber(const Type& t) { return t.base == Base::Float || isTriple(t.base); }

// Within the domain of a function, far from its ends.
struct Domain {
  float low = .2f, high = 1.8f;
};
Domain domainOf(std::string_view name, uint32_t argument) {
  if (name == "acos" || name == "asin") return {-.8f, .8f};
  if (name == "tan") return {-1, 1};
  if (name == "pow" && argument == 1) return {-1, 2};
  if (name == "log" && argument == 1) return {2, 5};
  if (name == "fmod" || name == "mod") return argument == 0 ? Domain{-3, 3} : Domain{1.3f, 1.6f};
  if (name == "smoothstep" || name == "linearstep" || name == "smooth_linearstep")
    return argument == 0   ? Domain{-.3f, .1f}
           : argument == 1 ? Domain{1.1f, 1.4f}
           : argument == 2 ? Domain{0, 1.2f}
                           : Domain{.2f, .3f};
  if (name == "spline" || name == "splineinverse") return argument == 1 ? Domain{.1f, .9f} : Domain{-.3f, 2};
  if (name.find("noise") != std::string_view::npos) return {-.6f, .9f};
  if (name == "refract") return argument == 2 ? Domain{.6f, .8f} : Domain{-.6f, .5f};
  if (name == "transformc" || name == "luminance") return {.1f, .9f};
  return {};
}

// A value of the type that moves with u and v, or stands still.
std::string valueText(const Type& type, Domain d, bool moves, uint32_t seed) {
  const auto number = [&](uint32_t k) {
    const float a = .35f + .1f * float((seed * 5 + k * 3) % 4), b = .55f - .1f * float((seed * 3 + k * 7) % 4),
                c = .5f * (1 - a) * float((seed + k) % 3);
    char text[128];
    if (moves)
      std::snprintf(text, sizeof text, "(%g + %g * (%g * u + %g * v + %g))", double(d.low), double(d.high - d.low),
                    double(a), double(b) * .6, double(c) * .5);
    else
      std::snprintf(text, sizeof text, "%g",
                    double(d.low + (d.high - d.low) * (.2f + .17f * float((seed * 2 + k) % 4))));
    return std::string(text);
  };
  if (type.base == Base::Float) return number(0);
  return nameOf(type) + "(" + number(0) + ", " + number(1) + ", " + number(2) + ")";
}

struct Case {
  std::string name, source;
  bool hasNone = false;     // the derivatives are 0 by definition
  bool isNegative = false;  // the reference has the opposite sign
  bool jumps = false;       // has small jumps: kernels that end at a radius
};

// All of them: the name tells function, overload, and the argument that moves.
std::vector<Case> cases() {
  std::vector<Case> all;
  for (const front::Builtin& b : front::allBuiltins()) {
    const uint32_t flags = factsOf(b.opcode).flags;
    if (b.opcode == Opcode::MakeClosure || b.opcode == Opcode::GetAttribute || b.opcode == Opcode::SetMessage ||
        b.opcode == Opcode::GetMessage)
      continue;
    for (const front::Signature& s : front::signaturesOf(b)) {
      const bool isSinCos = b.opcode == Opcode::SinCos;
      const Type result = isSinCos ? s.formals[0].type : s.result;
      if (!isNumber(result)) continue;
      // lookups whose derivatives are given do not follow their coordinates
      if ((b.opcode == Opcode::Texture && s.count > 3) ||
          ((b.opcode == Opcode::Texture3d || b.opcode == Opcode::Environment) && s.count > 2))
        continue;
      std::vector<std::string> words = {""};
      if (s.formals[0].type.base == Base::String) {
        if (b.name == "noise")
          words = {"perlin", "uperlin", "simplex", "usimplex", "gabor", "cell", "hash"};
        else if (b.name == "pnoise")
          words = {"perlin", "uperlin", "gabor", "cell"};
        else if (b.name == "spline")
          words = {"catmull-rom", "bezier", "bspline", "hermite", "linear", "constant"};
        else if (b.name == "splineinverse")
          words = {"linear", "catmull-rom", "bspline"};
        else if (b.name == "transformc")
          words = {"hsv", "hsl", "YIQ", "XYZ", "xyY", "sRGB"};
        else
          words = {"object"};
      }
      for (const std::string& word : words)
        for (uint32_t moving = 0; moving <= s.count; ++moving) {
          const bool isAll = moving == s.count;
          if (!isAll && !isNumber(s.formals[moving].type)) continue;
          std::string arguments, before;
          for (uint32_t i = 0; i < s.count; ++i) {
            const Type& t = s.formals[i].type;
            if (i) arguments += ", ";
            const bool moves = isAll || moving == i;
            if (t.base == Base::String) {
              const bool isTo = i == 1 && (b.name == "transform" || b.name == "transformc");
              arguments += isTo ? b.name == "transform" ? "\"shader\"" : "\"rgb\"" : "\"" + word + "\"";
            } else if (t.base == Base::Matrix) {
              arguments += "matrix(1, 2, 0, 0.1, 0, 3, 1, 0, 2, 0, 1, 0, 1, 1, 0, 2)";
            } else if (t.base == Base::Int) {
              arguments += t.arrayLength == 0 && b.name.starts_with("spline") ? "4" : "1";
            } else if (t.arrayLength != 0 || (s.rest == '+' && i + 1 == s.count)) {
              // knots rise, so that a spline has an inverse
              std::string list;
              for (uint32_t k = 0; k < 4; ++k)
                list += (k ? ", " : "") + valueText({t.base, 0, -1}, {-.5f + float(k), -.2f + float(k)}, moves, k);
              if (t.arrayLength != 0) {
                before += nameOf({t.base, 0, -1}) + " a" + std::to_string(i) + "[4] = {" + list + "}; ";
                arguments += "a" + std::to_string(i);
              } else {
                arguments += list;
              }
            } else if (s.formals[i].isOutput) {
              arguments += i == 1 ? "r" : "other";
            } else {
              arguments += valueText(t, domainOf(b.name, i), moves, i + 1);
            }
          }
          const std::string type = nameOf(result), slope = type == "point" || type == "normal" ? "vector" : type;
          const std::string call = std::string(b.name) + "(" + arguments + ");";
          Case c;
          c.name = type + " " + std::string(b.name) + " " + arguments;
          c.source = "shader t(output " + type + " r = 0, output " + slope + " x = 0, output " + slope +
                     " y = 0) {\n" + before + type + " other;\n" + (isSinCos ? call : "r = " + call) +
                     "\nx = Dx(r);\ny = Dy(r);\n}\n";
          // of fmod the second operand's derivatives are dropped
          const bool isNone =
              (b.name == "fmod" && moving == 1) || (b.name == "splineinverse" && moving > 1 && !isAll);
          c.hasNone = (flags & kOpDropsDerivs) || isNone || word == "cell" || word == "hash" || word == "constant";
          c.jumps = word == "gabor";
          if (isAll && (b.name == "fmod" || b.name == "splineinverse")) continue;  // neither the one nor the other
          c.isNegative = b.name == "atan2";
          all.push_back(std::move(c));
        }
    }
  }
  return all;
}

TEST(Programs, EveryFunctionsDerivativesAreThoseOfDifferences) {
  constexpr uint32_t n = 200;
  constexpr float h = 1.f / 512;
  const std::vector<Case> all = cases();
  EXPECT_GE(all.size(), 700u);
  const Points here(n), right(n, h, 0), left(n, -h, 0), up(n, 0, h), down(n, 0, -h);
  size_t decided = 0, none = 0;
  for (const Case& c : all) {
    SCOPED_TRACE(c.name);
    CompileResult compiled = compile(c.source, "t.osl");
    for (const CompileMessage& m : compiled.messages)
      if (!compiled.ok()) ADD_FAILURE() << m.str();
    if (!compiled.ok()) continue;
    ShaderGroup group;
    group.layers.push_back({std::make_shared<const Shader>(std::move(*compiled.shader)), "layer", {}});
    group.outputs = {"r", "x", "y"};
    std::string error;
    const auto program = compileGroup(group, {}, error);
    ASSERT_TRUE(program) << error;
    const auto at = [&](const Points& p, float du, float dv) { return runOnce(*program, group, p, du, dv); };
    const Ran ran = at(here, 0, 0), r = at(right, h, 0), l = at(left, -h, 0), u = at(up, 0, h), d = at(down, 0, -h);
    EXPECT_TRUE(ran.messages.empty()) << ran.messages[0].text;
    std::vector<Ran> others;
    for (const uint32_t width : {1u, 4u, 16u}) {
      MachineOptions other = optionsOfWidth(width);
      other.optimise = width != 1;
      others.push_back(runOnce(*compileGroup(group, other, error), group, here));
    }
    // without derivatives the same value comes from other kernels
    ShaderGroup plain = group;
    plain.outputs = {"r"};
    const Ran value = runOnce(*compileGroup(plain, {}, error), plain, here);
    size_t good = 0, smooth = 0, bad = 0;
    std::string first;
    const auto wrong = [&](const std::string& what) {
      if (bad++ == 0) first = what;
    };
    for (const auto& [name, values] : ran.values) {
      for (const Ran& alone : others)
        for (uint32_t i = 0; i < n; ++i)
          if (std::memcmp(&values[i], &alone.values.at(name)[i], 4) != 0) {
            ADD_FAILURE() << name << " of point " << i << " differs by width: " << values[i] << " and "
                          << alone.values.at(name)[i];
            break;
          }
      if (name[0] != 'r') continue;
      const std::string tail = name.substr(1);
      for (uint32_t i = 0; i < n; ++i) {
        const double v = values[i], other = value.values.at(name)[i];
        if (std::fabs(v - other) > 1e-5 * (1 + std::fabs(v)))
          wrong(name + " of point " + std::to_string(i) + " is " + std::to_string(v) + " with derivatives, " +
                std::to_string(other) + " without");
        for (const bool alongX : {true, false}) {
          const double a = (alongX ? r : u).values.at(name)[i], b = (alongX ? l : d).values.at(name)[i];
          const double got = double(ran.values.at((alongX ? "x" : "y") + tail)[i]) / Points::kStep,
                       slope = (a - b) / (2 * double(h)) * (c.isNegative ? -1 : 1);
          if (c.hasNone) {
            ++none;
            if (got != 0)
              wrong(name + " of point " + std::to_string(i) + ": " + std::to_string(got) + " a unit instead of none");
            continue;
          }
          const double scale = std::max(1.0, std::fabs(slope)), rough = std::fabs((a - v) - (v - b)) / double(h);
          ++good;
          if (rough > .05 * scale) continue;
          ++smooth;
          // the language's approximations have slopes a little off; rounding of the difference is 2^-23 |v| / h; a
          // kink or a jump between the points moves the slope by half of what it lets left and right differ
          const double tolerance = 2e-3 * scale + 1e-4 * std::fabs(v) + .51 * rough;
          if (std::fabs(got - slope) > tolerance)
            wrong(name + " of point " + std::to_string(i) + (alongX ? ", x: " : ", y: ") + std::to_string(got) +
                  " a unit instead of " + std::to_string(slope));
        }
      }
    }
    decided += smooth;
    if (!c.hasNone) {
      EXPECT_GT(smooth * 2, good) << "too many kinks";
    }
    if (bad > (c.jumps ? good / 100 : 0)) ADD_FAILURE() << bad << " values: " << first << "\n" << c.source;
  }
  EXPECT_GT(decided, 500000u);
  EXPECT_GT(none, 100000u);
}

}  // namespace
}  // namespace kinora::oracle

// Code for the library's larger functions: noises, hashes.
#include <algorithm>

#include "language/library/color_system.h"
#include "language/library/spline_basis.h"
#include "language/vm/codegen.h"

namespace kinora::language {

void CodeGenerator::noise(const Instruction& in) {
  const auto& args = in.arguments;
  const auto base = [&](size_t i) { return shader_.symbols[size_t(args[i])].type.base; };
  size_t first = 1;
  std::string name = in.opcode == Opcode::SNoise || in.opcode == Opcode::PSNoise ? "snoise"
                     : in.opcode == Opcode::CellNoise                            ? "cellnoise"
                     : in.opcode == Opcode::HashNoise                            ? "hashnoise"
                                                                                 : "noise";
  const bool periodic = in.opcode == Opcode::PNoise || in.opcode == Opcode::PSNoise;
  if (args.size() > 2 && base(1) == Base::String && in.opcode != Opcode::Hash) {
    const std::string* given = constantString(args[1]);
    if (!given) return scalar(in, Scalar::Refuse, "noise of a name that is not known before the run");
    name = *given;
    ++first;
  }
  size_t end = first;
  while (end < args.size() && base(end) != Base::String) ++end;
  if (in.opcode == Opcode::Hash && args.size() == 2 && base(1) == Base::String) return scalar(in, Scalar::HashString);
  // coordinates one by one
  std::vector<Operand> numbers;
  for (size_t i = first; i < end; ++i) {
    const Operand o = in.opcode == Opcode::Hash ? operand(args[i]) : number(args[i]);
    for (uint32_t c = 0; c < o.components; ++c) {
      Operand one = part(o, c);
      one.base = o.base == Base::Int ? Base::Int : Base::Float;
      numbers.push_back(one);
    }
  }
  const size_t n = periodic ? numbers.size() / 2 : numbers.size();
  if (n < 1 || n > 4 || (periodic && numbers.size() != 2 * n))
    return fail(in, "noise of these operands is not known");
  bool varies = false, derivs = false;
  for (const Operand& o : numbers) varies |= o.varies;
  for (size_t k = 0; k < n; ++k) derivs |= numbers[k].derivs;
  if (in.opcode == Opcode::Hash) {
    const Target t = begin(args[0], !varies, {});
    reference(t.out.reg, t.out.at);
    for (const Operand& o : numbers) mixedWords(o, 1);
    emit(Noise(uint16_t(Noise::HashWords1) + uint16_t(n - 1)), t.once);
    return finish(t);
  }
  struct Kind {
    const char* name;
    Noise kernel;
    bool isUnsigned, hasDual;
  };
  static const Kind kKinds[] = {
      {"perlin", Noise::Perlin1, false, true},   {"snoise", Noise::Perlin1, false, true},
      {"psnoise", Noise::Perlin1, false, true},  {"uperlin", Noise::Perlin1, true, true},
      {"noise", Noise::Perlin1, true, true},     {"pnoise", Noise::Perlin1, true, true},
      {"simplex", Noise::Simplex1, false, true}, {"simplexnoise", Noise::Simplex1, false, true},
      {"usimplex", Noise::Simplex1, true, true}, {"usimplexnoise", Noise::Simplex1, true, true},
      {"cell", Noise::Cell1, false, false},      {"cellnoise", Noise::Cell1, false, false},
      {"hash", Noise::Hash1, false, false},      {"hashnoise", Noise::Hash1, false, false}};
  const auto kind = std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& k) { return name == k.name; });
  if (name == "gabor") return gabor(in, numbers, n, periodic, end);
  if (kind == std::end(kKinds)) {
    if (name == "null") return assign(in, args[0], constant(0.f));
    if (name == "unull") return assign(in, args[0], constant(0.5f));
    return scalar(in, Scalar::Refuse, "noise type \"" + name + "\"");
  }
  const bool triple = componentsOf(base(0)) == 3;
  const Target t = begin(args[0], !varies, {}, true);
  const bool dual = kind->hasDual && t.out.derivs && derivs;
  word(kind->isUnsigned);
  word(periodic);
  resultWords(t.out, dual);
  for (size_t k = 0; k < n; ++k) {
    if (dual)
      dualMixedWords(numbers[k], 1);
    else
      mixedWords(numbers[k], 1);
  }
  for (size_t k = n; k < numbers.size(); ++k) mixedWords(numbers[k], 1);
  const uint16_t at = uint16_t((n - 1) * 2 + triple);
  emit(Noise(uint16_t(kind->kernel) + (kind->hasDual ? at * 2 + dual : at)), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

void CodeGenerator::gabor(const Instruction& in, const std::vector<Operand>& numbers, size_t n, bool periodic,
                          size_t firstOption) {
  const auto& args = in.arguments;
  Operand anisotropic = constantInt(0), filter = constantInt(1), direction = temporary(Base::Vector, 3, false),
          bandwidth = constant(1.f), impulses = constant(16.f);
  images_.emplace_back(direction.reg, std::vector<uint32_t>{0x3f800000u, 0, 0});
  bool varies = false;
  for (const Operand& o : numbers) varies |= o.varies;
  for (size_t k = firstOption; k + 1 < args.size(); k += 2) {
    const std::string* token = constantString(args[k]);
    if (!token) return scalar(in, Scalar::Refuse, "an option of noise that is not known before the run");
    const Operand value = operand(args[k + 1]);
    if (*token == "anisotropic")
      anisotropic = value;
    else if (*token == "do_filter")
      filter = value;
    else if (*token == "direction")
      direction = asFloat(value);
    else if (*token == "bandwidth")
      bandwidth = asFloat(value);
    else if (*token == "impulses")
      impulses = asFloat(value);
    else
      continue;
    varies |= value.varies;
  }
  if (anisotropic.varies || filter.varies)
    return scalar(in, Scalar::Refuse, "gabor noise with options that differ from point to point");
  const Operand nought = constant(0.f), one = constant(1.f);
  const uint32_t c = uint32_t(componentsOf(shader_.symbols[size_t(args[0])].type.base));
  Operand out = temporary(c == 3 ? Base::Color : Base::Float, c, varies, true);
  word(periodic);
  resultWords(out, true);
  for (size_t k = 0; k < 3; ++k) dualMixedWords(k < n ? numbers[k] : nought, 1);
  for (size_t k = 0; k < 3; ++k) mixedWords(periodic && k < n ? numbers[n + k] : one, 1);
  reference(anisotropic.reg, anisotropic.at);
  reference(filter.reg, filter.at);
  mixedWords(direction, 3);
  mixedWords(bandwidth, 1);
  mixedWords(impulses, 1);
  emit(c == 3 ? Noise::Gaborx3 : Noise::Gabor, !varies);
  out.derivs = varies;
  assign(in, args[0], out);
}

void CodeGenerator::spectral(const Instruction& in, Spectral kernel) {
  const Operand a = number(in.arguments[1]);
  const Target t = begin(in.arguments[0], !a.varies, {a}, false);
  const bool dual = kernel == Spectral::Luminance && t.out.derivs && a.derivs;
  resultWords(t.out, dual);
  if (dual)
    dualMixedWords(a, 3);
  else
    mixedWords(a, 3);
  emit(Spectral(uint16_t(kernel) + dual), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

// From a space (null: RGB) to another (null: RGB).
void CodeGenerator::transformColor(const Instruction& in, SymbolId result, Operand color, const std::string* from,
                                   const std::string* to, bool isConstructor) {
  const auto find = [&](const std::string* name) {
    if (!name) return ColorSpace::Rgb;
    const std::string_view working = defaultColorSystem().name;
    return isConstructor ? findConstructorSpace(*name, working) : findColorSpace(*name, working);
  };
  const ColorSpace a = find(from), b = find(to);
  if (a == ColorSpace::Unknown || b == ColorSpace::Unknown) {
    word(0);
    word(site(in, "Unknown color space transformation \"" + (from ? *from : "RGB") + "\" -> \"" + (to ? *to : "RGB") +
                      "\""));
    word(uint32_t(2));  // a message of its own
    const Register mask = maskOf(region_);
    word(mask != rootMask_);
    reference(mask);
    emit(Scalar::Refuse, false);
    return assign(in, result, color);
  }
  const Target t = begin(result, !color.varies, {color}, false);
  const bool dual = !isConstructor && t.out.derivs && color.derivs;
  word(uint32_t(a));
  word(uint32_t(b));
  resultWords(t.out, dual);
  if (dual)
    dualMixedWords(color, 3);
  else
    mixedWords(color, 3);
  emit(dual ? Spectral::TransformColorD : Spectral::TransformColor, t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

// spline(basis, x, y0, ... yn | y[] | count, y[]), splineinverse alike
void CodeGenerator::spline(const Instruction& in) {
  const auto& args = in.arguments;
  const std::string* basis = args.size() > 3 ? constantString(args[1]) : nullptr;
  if (!basis) return scalar(in, Scalar::Refuse, "a spline basis that is not known before the run");
  const uint32_t n = uint32_t(std::max(1, componentsOf(shader_.symbols[size_t(args[0])].type.base)));
  const Operand x = number(args[2]);
  Operand knots;
  uint32_t count = 0;
  if (shader_.symbols[size_t(args.back())].type.arrayLength) {
    knots = operand(args.back());
    count = knots.elements;
    int32_t wanted = 0;
    if (args.size() == 5 && constantInt(args[3], wanted))
      count = uint32_t(std::clamp(wanted, 1, int32_t(count)));
    else if (args.size() == 5)
      return scalar(in, Scalar::Refuse,
                    "a number of knots that is not known before the run, out of an array of more than 64");
  } else {
    count = uint32_t(args.size() - 3);
    bool varies = false, derivs = false;
    std::vector<Operand> values;
    for (size_t k = 3; k < args.size(); ++k) {
      values.push_back(number(args[k]));
      varies |= values.back().varies;
      derivs |= values.back().derivs;
    }
    derivs &= a_.hasDerivs[size_t(args[0])] != 0;
    knots = temporary(Base::Float, count * n, varies, derivs);
    knots.elements = count;
    knots.components = n;
    for (uint32_t k = 0; k < count; ++k)
      for (uint32_t d = 0; d < (derivs ? 3u : 1u); ++d) {
        const Operand& o = values[k];
        const uint32_t to = d * count * n + k * n;
        if (d && !o.derivs)
          copyCells(knots.reg, to, zeros(), 0, n, true, 0);
        else
          copyCells(knots.reg, to, o.reg, o.at + d * (registers_[size_t(o.reg)].cells / 3), n, o.varies,
                    o.components > 1);
      }
  }
  if (knots.components != n) return fail(in, "a spline's knots must be of the type of its result");
  const Target t = begin(args[0], !x.varies && !knots.varies, {x, knots}, false);
  const bool inverse = in.opcode == Opcode::SplineInverse;
  const bool knotDerivs = knots.derivs && !inverse;
  const bool dual = t.out.derivs && (x.derivs || knotDerivs);
  word(uint32_t(splineBasis(*basis)));
  word(count);
  for (uint32_t d = 0; d < 3; ++d)
    reference(knots.reg, d && knotDerivs ? d * (registers_[size_t(knots.reg)].cells / 3) : 0);
  resultWords(t.out, dual);
  if (dual)
    dualMixedWords(x, 1);
  else
    mixedWords(x, 1);
  const Splines first = inverse ? Splines::InverseU : n == 3 ? Splines::Spline3U : Splines::Spline1U;
  emit(Splines(uint16_t(first) + (dual ? (knotDerivs ? 4 : 2 + knots.varies) : knots.varies)), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

}  // namespace kinora::language

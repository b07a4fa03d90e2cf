// Code for the library's larger functions: noises, hashes.
#include <algorithm>

#include "language/vm/codegen.h"

namespace kinora::language {

void CodeGenerator::noise(const Instruction& in) {
  const auto& args = in.arguments;
  const auto base = [&](size_t i) { return shader_.symbols[size_t(args[i])].type.base; };
  size_t first = 1;
  std::string name = in.opcode == Opcode::SNoise || in.opcode == Opcode::PSNoise ? "snoise" : in.opcode == Opcode::CellNoise ? "cellnoise" : in.opcode == Opcode::HashNoise ? "hashnoise" : "noise";
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
  if (n < 1 || n > 4 || (periodic && numbers.size() != 2 * n)) return fail(in, "noise of these operands is not known");
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
      {"perlin", Noise::Perlin1, false, true},       {"snoise", Noise::Perlin1, false, true},
      {"psnoise", Noise::Perlin1, false, true},      {"uperlin", Noise::Perlin1, true, true},
      {"noise", Noise::Perlin1, true, true},         {"pnoise", Noise::Perlin1, true, true},
      {"simplex", Noise::Simplex1, false, true},     {"simplexnoise", Noise::Simplex1, false, true},
      {"usimplex", Noise::Simplex1, true, true},     {"usimplexnoise", Noise::Simplex1, true, true},
      {"cell", Noise::Cell1, false, false},          {"cellnoise", Noise::Cell1, false, false},
      {"hash", Noise::Hash1, false, false},          {"hashnoise", Noise::Hash1, false, false}};
  const auto kind = std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& k) { return name == k.name; });
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
    if (dual) dualMixedWords(numbers[k], 1);
    else mixedWords(numbers[k], 1);
  }
  for (size_t k = n; k < numbers.size(); ++k) mixedWords(numbers[k], 1);
  const uint16_t at = uint16_t((n - 1) * 2 + triple);
  emit(Noise(uint16_t(kind->kernel) + (kind->hasDual ? at * 2 + dual : at)), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

}  // namespace kinora::language

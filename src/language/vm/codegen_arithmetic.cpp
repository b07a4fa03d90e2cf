// The kernels of one operation each: arithmetic, comparisons, triples, derivatives, transforms, calls of services.
#include <algorithm>

#include "language/vm/codegen.h"

namespace kinora::language {

const std::string* CodeGenerator::constantString(SymbolId s) const {
  const Symbol& symbol = shader_.symbols[size_t(s)];
  return symbol.kind == SymbolKind::Constant && symbol.type.base == Base::String && symbol.values.strings.size() == 1
             ? &symbol.values.strings[0]
             : nullptr;
}
bool CodeGenerator::constantInt(SymbolId s, int32_t& value) const {
  const Symbol& symbol = shader_.symbols[size_t(s)];
  if (symbol.kind != SymbolKind::Constant || symbol.type.base != Base::Int || symbol.values.ints.size() != 1)
    return false;
  value = symbol.values.ints[0];
  return true;
}

CodeGenerator::Operand CodeGenerator::asFloat(Operand o) {
  if (o.base != Base::Int) return o;
  Operand made = temporary(Base::Float, o.components, o.varies);
  word(o.components);
  reference(made.reg);
  reference(o.reg, o.at);
  word(1);
  emit(Integer::ToFloat, !o.varies);
  return made;
}

// A number as that multiple of the identity.
CodeGenerator::Operand CodeGenerator::asMatrix(Operand o) {
  if (o.components == 16) return o;
  o = asFloat(o);
  Operand made = temporary(Base::Matrix, 16, o.varies);
  word(16);
  reference(made.reg);
  word(0);
  emit(Memory::Fill, !o.varies);
  for (uint32_t k = 0; k < 4; ++k) copyCells(made.reg, 5 * k, o.reg, o.at, 1, o.varies, 0);
  return made;
}

void CodeGenerator::assign(const Instruction& in, SymbolId to, Operand from) {
  const Symbol& symbol = shader_.symbols[size_t(to)];
  const Base base = symbol.type.base;
  if (base == Base::Closure || base == Base::Struct) return;
  const Operand whole = operand(to);
  if (base == Base::Int && isFloatBased(from.base) && from.components == 1) {
    const Target t = begin(to, !from.varies, {from});
    word(1);
    reference(t.out.reg, t.out.at);
    reference(from.reg, from.at);
    word(0);
    emit(Integer::ToInt, t.once);
    return finish(t);
  }
  if (from.base == Base::Int && base != Base::Int) from = asFloat(from);
  if (base == Base::Matrix && from.components == 1) from = asMatrix(from);
  if ((base == Base::String) != (from.base == Base::String) ||
      (whole.components != from.components && from.components != 1))
    return fail(in, "assign: a " + language::nameOf(symbol.type) + " cannot take such a value");
  const bool array = whole.elements > 1 || from.elements > 1;
  const uint32_t n = array ? std::min(whole.cells(), from.cells()) : whole.components;
  const uint32_t step = from.components > 1 || array ? 1 : 0;
  // straight into its place where that needs no blend
  if (whole.varies && !a_.blends(region_, to)) {
    copyCells(whole.reg, 0, from.reg, from.at, n, from.varies, step);
    if (!whole.derivs) return;
    if (!from.derivs) return clearDerivs(whole, false);
    const uint32_t all = registers_[size_t(from.reg)].cells / 3;
    for (uint32_t d = 1; d <= 2; ++d)
      copyCells(whole.reg, d * whole.cells(), from.reg, from.at + d * all, n, true, step);
    return;
  }
  if (!whole.varies) return copyCells(whole.reg, 0, from.reg, from.at, n, false, step);
  const Register mask = maskOf(region_);
  word(n);
  reference(whole.reg);
  reference(from.reg, from.at);
  word(step);
  reference(mask);
  emit(from.varies ? Memory::Blend : Memory::BlendUniform, false);
  if (!whole.derivs) return;
  if (from.derivs) {
    const uint32_t all = registers_[size_t(from.reg)].cells / 3;
    for (uint32_t d = 1; d <= 2; ++d) {
      word(n);
      reference(whole.reg, d * whole.cells());
      reference(from.reg, from.at + d * all);
      word(step);
      reference(mask);
      emit(Memory::Blend, false);
    }
  } else {
    const Operand zero = constant(0.f);
    word(2 * whole.cells());
    reference(whole.reg, whole.cells());
    reference(zero.reg);
    word(0);
    reference(mask);
    emit(Memory::BlendUniform, false);
  }
}

void CodeGenerator::arithmetic(const Instruction& in, Arithmetic kernel, Integer ints) {
  if (pair(in, kernel)) return;
  const SymbolId result = in.arguments[0];
  const Base base = shader_.symbols[size_t(result)].type.base;
  Operand a = operand(in.arguments[1]), b = operand(in.arguments[2]);
  if (base == Base::Int && a.base == Base::Int && b.base == Base::Int) return integers(in, ints);
  if (base == Base::Closure) return;
  a = asFloat(a);
  b = asFloat(b);
  if (base == Base::Matrix && (kernel == Arithmetic::Mul || kernel == Arithmetic::Div))
    return matrixArithmetic(in, a, b);
  const uint32_t n = uint32_t(componentsOf(base));
  if (!isFloatBased(base) || (a.components != n && a.components != 1) || (b.components != n && b.components != 1))
    return fail(in, std::string(factsOf(in.opcode).name) + " does not take operands of these types");
  const Symbol& divisor = shader_.symbols[size_t(in.arguments[2])];
  if (kernel == Arithmetic::Div && divisor.kind == SymbolKind::Constant) {
    const bool plain = divisor.type.base == Base::Int
                           ? divisor.values.ints[0] != 0
                           : std::none_of(divisor.values.floats.begin(), divisor.values.floats.end(),
                                          [](float f) { return f == 0; });
    if (plain) kernel = Arithmetic::DivPlain;
  }
  const Target t = begin(result, !a.varies && !b.varies, {a, b});
  const bool dual = t.out.derivs && (a.derivs || b.derivs);
  const int kinds = t.once ? 0 : !a.varies ? 1 : !b.varies ? 2 : 0;
  if (t.blends && !t.spreads && !t.final.derivs && options_.optimise) {
    word(n);
    resultWords(t.final, false);
    plainWords(a, n);
    plainWords(b, n);
    reference(maskOf(region_));
    emit(variant(Fused::Masked, int(kernel) / 6 * 3 + kinds), false);
    return;
  }
  const int by = kinds + (dual ? 3 : 0);
  word(n);
  resultWords(t.out, dual);
  if (dual) {
    dualWords(a, n);
    dualWords(b, n);
  } else {
    plainWords(a, n);
    plainWords(b, n);
  }
  emit(variant(kernel, by), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

void CodeGenerator::matrixArithmetic(const Instruction& in, Operand a, Operand b) {
  const bool division = in.opcode == Opcode::Div;
  if ((a.components != 16 && a.components != 1) || (b.components != 16 && b.components != 1))
    return fail(in, "a matrix operation does not take operands of these types");
  if (b.components == 1 || (a.components == 1 && !division)) {
    const Target t = begin(in.arguments[0], !a.varies && !b.varies, {a, b});
    word(16);
    resultWords(t.out, false);
    plainWords(a, 16);
    plainWords(b, 16);
    emit(variant(division ? Arithmetic::Div : Arithmetic::Mul, t.once      ? 0
                                                               : !a.varies ? 1
                                                               : !b.varies ? 2
                                                                           : 0),
         t.once);
    return finish(t);
  }
  if (division) {
    Operand inverse = temporary(Base::Matrix, 16, b.varies);
    reference(inverse.reg);
    reference(b.reg, b.at);
    word(b.varies);
    emit(Vector::MatrixInverse, !b.varies);
    b = inverse;
    if (a.components == 1) {
      const Target t = begin(in.arguments[0], !a.varies && !b.varies, {a, b});
      word(16);
      resultWords(t.out, false);
      plainWords(a, 16);
      plainWords(b, 16);
      emit(variant(Arithmetic::Mul, t.once ? 0 : !a.varies ? 1 : !b.varies ? 2 : 0), t.once);
      return finish(t);
    }
  }
  const Target t = begin(in.arguments[0], !a.varies && !b.varies, {a, b}, false);
  resultWords(t.out, false);
  for (const Operand& o : {a, b}) {
    reference(o.reg, o.at);
    word(o.varies);
  }
  emit(Vector::MatrixMul, t.once);
  finish(t);
}

void CodeGenerator::unary(const Instruction& in, Math kernel, bool hasDual) {
  const uint32_t n = uint32_t(componentsOf(shader_.symbols[size_t(in.arguments[0])].type.base));
  const Operand a = number(in.arguments[1]);
  if (a.components != n && a.components != 1)
    return fail(in, std::string(factsOf(in.opcode).name) + " does not take operands of these types");
  const Target t = begin(in.arguments[0], !a.varies, {a});
  const bool dual = hasDual && t.out.derivs && a.derivs;
  word(n);
  resultWords(t.out, dual);
  if (dual)
    dualWords(a, n);
  else
    plainWords(a, n);
  emit(variant(kernel, dual ? 1 : 0), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

void CodeGenerator::mixed(const Instruction& in, Mixed kernel, uint32_t firstOperand, uint32_t operands) {
  const uint32_t n = uint32_t(componentsOf(shader_.symbols[size_t(in.arguments[0])].type.base));
  Operand o[4];
  bool varies = false, derivs = false;
  for (uint32_t k = 0; k < operands; ++k) {
    // a choice by an int, and among ints, is made by the bits
    const bool asItIs =
        kernel == Mixed::SelectI && (k == 2 || shader_.symbols[size_t(in.arguments[0])].type.base == Base::Int ||
                                     shader_.symbols[size_t(in.arguments[0])].type.base == Base::String);
    o[k] = asItIs ? operand(in.arguments[firstOperand + k]) : number(in.arguments[firstOperand + k]);
    if (o[k].components != n && o[k].components != 1)
      return fail(in, std::string(factsOf(in.opcode).name) + " does not take operands of these types");
    varies |= o[k].varies;
    derivs |= o[k].derivs;
  }
  const Target t = begin(in.arguments[0], !varies, {o[0], o[1], o[2], o[3]});
  const bool dual = t.out.derivs && derivs;
  word(n);
  resultWords(t.out, dual);
  for (uint32_t k = 0; k < operands; ++k) {
    if (dual)
      dualMixedWords(o[k], n);
    else
      mixedWords(o[k], n);
  }
  emit(variant(kernel, dual ? 1 : 0), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

void CodeGenerator::integers(const Instruction& in, Integer kernel) {
  const Operand a = operand(in.arguments[1]), b = operand(in.arguments[2]);
  if (a.base != Base::Int || b.base != Base::Int || shader_.symbols[size_t(in.arguments[0])].type.base != Base::Int)
    return fail(in, std::string(factsOf(in.opcode).name) + " takes integers");
  const Target t = begin(in.arguments[0], !a.varies && !b.varies, {a, b});
  word(1);
  resultWords(t.out, false);
  mixedWords(a, 1);
  mixedWords(b, 1);
  emit(kernel, t.once);
  finish(t);
}

void CodeGenerator::integerUnary(const Instruction& in, Integer kernel) {
  const Operand a = operand(in.arguments[1]);
  const Target t = begin(in.arguments[0], !a.varies, {a});
  word(1);
  resultWords(t.out, false);
  plainWords(a, 1);
  emit(kernel, t.once);
  finish(t);
}

void CodeGenerator::compare(const Instruction& in, Mixed floats, Mixed ints) {
  Operand a = operand(in.arguments[1]), b = operand(in.arguments[2]);
  const bool whole = a.base != Base::Closure && b.base != Base::Closure;
  if (!whole) {  // closures compare with nothing but 0
    Instruction made = in;
    return assign(made, in.arguments[0], constantInt(0));
  }
  const bool asInts = (a.base == Base::Int && b.base == Base::Int) || a.base == Base::String;
  if ((a.base == Base::String) != (b.base == Base::String)) return fail(in, "a string compares with strings only");
  if (!asInts) {
    a = asFloat(a);
    b = asFloat(b);
    if (a.components == 16 || b.components == 16) {
      a = asMatrix(a);
      b = asMatrix(b);
    }
  }
  const uint32_t n = std::max(a.components, b.components);
  if ((a.components != n && a.components != 1) || (b.components != n && b.components != 1))
    return fail(in, "a comparison does not take operands of these types");
  const Target t = begin(in.arguments[0], !a.varies && !b.varies, {a, b}, false);
  word(n);
  resultWords(t.out, false);
  mixedWords(a, n);
  mixedWords(b, n);
  emit(asInts ? ints : floats, t.once);
  finish(t);
}

void CodeGenerator::vector(const Instruction& in, Vector kernel, uint32_t operands, bool hasDual) {
  Operand o[3];
  bool varies = false, derivs = false;
  for (uint32_t k = 0; k < operands; ++k) {
    o[k] = number(in.arguments[1 + k]);
    varies |= o[k].varies;
    derivs |= o[k].derivs;
  }
  const Target t = begin(in.arguments[0], !varies, {o[0], o[1], o[2]}, false);
  const bool dual = hasDual && t.out.derivs && derivs;
  resultWords(t.out, dual);
  for (uint32_t k = 0; k < operands; ++k) {
    if (dual)
      dualMixedWords(o[k], 3);
    else
      mixedWords(o[k], 3);
  }
  emit(variant(kernel, dual ? 1 : 0), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

// Dx, Dy: the derivatives are a value. Dz is 0 on surfaces.
void CodeGenerator::derivative(const Instruction& in, int axis) {
  const Operand a = operand(in.arguments[1]);
  if (axis > 2 || !a.derivs) {
    Operand zero = constant(0.f);
    return assign(in, in.arguments[0], zero);
  }
  Operand d = a;
  d.at += uint32_t(axis) * (registers_[size_t(a.reg)].cells / 3);
  d.derivs = false;
  assign(in, in.arguments[0], d);
}

// filterwidth, area, calculatenormal
void CodeGenerator::swept(const Instruction& in) {
  const Operand a = operand(in.arguments[1]);
  if (!a.derivs) return assign(in, in.arguments[0], constant(0.f));
  const Target t = begin(in.arguments[0], false, {a}, false);
  if (in.opcode == Opcode::FilterWidth) {
    word(a.components);
    resultWords(t.out, false);
    dualWords(a, a.components);
    emit(Vector::FilterWidth, false);
  } else {
    resultWords(t.out, false);
    dualMixedWords(a, 3);
    emit(in.opcode == Opcode::Area ? Vector::AreaOf : Vector::NormalOf, false);
  }
  clearDerivs(t.out, t.once);
  finish(t);
}

// The matrix from one named space to another; kNone: common. Varying: the renderer may know a space for each point.
CodeGenerator::Operand CodeGenerator::matrixBetween(const Instruction& in, SymbolId from, SymbolId to) {
  const Operand found = temporary(Base::Int, 1, true), out = temporary(Base::Matrix, 16, true);
  word(site(in));
  reference(found.reg);
  reference(out.reg);
  for (const SymbolId s : {from, to}) {
    if (s == kNone) {
      const Operand none = constantInt(0);
      mixedWords(none, 1);
    } else {
      mixedWords(operand(s), 1);
    }
  }
  const Register mask = maskOf(region_);
  word(mask != rootMask_);
  if (mask != rootMask_) reference(mask);
  emit(Scalar::GetMatrix, false);
  if (in.opcode == Opcode::GetMatrix) {
    assign(in, in.arguments[0], found);
    assign(in, in.arguments.back(), out);
  }
  return out;
}

void CodeGenerator::transform(const Instruction& in, Vector kernel, bool isNormal) {
  // result, [from,] to or matrix, triple
  const SymbolId value = in.arguments.back();
  Operand m;
  if (in.arguments.size() == 3 && shader_.symbols[size_t(in.arguments[1])].type.base == Base::Matrix)
    m = operand(in.arguments[1]);
  else if (in.arguments.size() == 3)
    m = matrixBetween(in, kNone, in.arguments[1]);
  else if (in.arguments.size() == 4)
    m = matrixBetween(in, in.arguments[1], in.arguments[2]);
  else
    return fail(in, "transform takes a matrix or one or two spaces");
  const Operand v = number(value);
  if (isNormal) {
    const Operand inverse = temporary(Base::Matrix, 16, m.varies);
    reference(inverse.reg);
    reference(m.reg, m.at);
    word(m.varies);
    emit(Vector::MatrixInverse, !m.varies);
    m = inverse;
  }
  const Target t = begin(in.arguments[0], !m.varies && !v.varies, {m, v}, false);
  const bool dual = t.out.derivs && v.derivs;
  resultWords(t.out, dual);
  if (dual)
    dualMixedWords(v, 3);
  else
    mixedWords(v, 3);
  reference(m.reg, m.at);
  word(m.varies);
  emit(variant(kernel, dual ? 1 : 0), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

// Work point by point: number of arguments, site, extra, has a mask, mask, then for each {cell, base | flags, cells,
// dx cell}; the kernel writes only points of the mask.
void CodeGenerator::scalar(const Instruction& in, Scalar kernel, std::string name, uint32_t extra) {
  bool varies = false;
  bool anyVaryingResult = false;
  for (uint32_t i = 0; i < in.arguments.size(); ++i) {
    const bool v = a_.isVarying[size_t(in.arguments[i])];
    const char access = accessOf(shader_, in, i);
    if (access != 'w') varies |= v;
    if (access != 'r') anyVaryingResult |= v;
  }
  const bool messages = in.opcode == Opcode::Printf || in.opcode == Opcode::Error || in.opcode == Opcode::Warning ||
                        in.opcode == Opcode::Fprintf || in.opcode == Opcode::Complain;
  const bool once = !varies && !anyVaryingResult && !messages;
  for (const SymbolId s : in.arguments) operand(s);
  word(uint32_t(in.arguments.size()));
  word(site(in, std::move(name)));
  word(extra);
  const Register mask = maskOf(region_);
  word(mask != rootMask_ && !once);
  reference(mask);
  for (const SymbolId s : in.arguments) {
    const Operand o = operand(s);
    reference(o.reg, o.at);
    word(uint32_t(o.base) | uint32_t(o.varies) << 8 | uint32_t(o.derivs) << 9 |
         uint32_t(shader_.symbols[size_t(s)].type.arrayLength != 0) << 10);
    word(o.cells());
    if (o.derivs)
      reference(o.reg, o.at + o.cells());
    else
      word(0);
  }
  emit(kernel, once);
  if (kernel == Scalar::Refuse && !in.arguments.empty() &&
      accessOf(shader_, in, 0) == 'w') {  // the answer is nothing
    const Operand o = operand(in.arguments[0]), zero = constant(0.f);
    word(o.cells());
    reference(o.reg, o.at);
    reference(zero.reg);
    word(0);
    if (once) {
      emit(Memory::Copy, true);
    } else {
      reference(mask);
      emit(Memory::BlendUniform, false);
    }
  }
  // the kernels leave derivatives alone
  for (uint32_t i = 0; i < in.arguments.size(); ++i) {
    const Operand o = operand(in.arguments[i]);
    if (accessOf(shader_, in, i) == 'r' || !o.derivs || in.opcode == Opcode::Texture ||
        in.opcode == Opcode::Texture3d || in.opcode == Opcode::Environment || in.opcode == Opcode::DebugUninit)
      continue;
    const Operand zero = constant(0.f);
    word(2 * o.cells());
    reference(o.reg, o.cells());
    reference(zero.reg);
    word(0);
    reference(maskOf(region_));
    emit(Memory::BlendUniform, false);
  }
}

}  // namespace kinora::language

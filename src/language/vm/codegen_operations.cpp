// Which kernel does each operation, by the types of its operands.
#include <algorithm>

#include "language/vm/codegen.h"

namespace kinora::language {

const std::string* CodeGenerator::constantString(SymbolId s) const {
  const Symbol& symbol = shader_.symbols[size_t(s)];
  return symbol.kind == SymbolKind::Constant && symbol.type.base == Base::String && symbol.values.strings.size() == 1 ? &symbol.values.strings[0] : nullptr;
}
bool CodeGenerator::constantInt(SymbolId s, int32_t& value) const {
  const Symbol& symbol = shader_.symbols[size_t(s)];
  if (symbol.kind != SymbolKind::Constant || symbol.type.base != Base::Int || symbol.values.ints.size() != 1) return false;
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
  if ((base == Base::String) != (from.base == Base::String) || (whole.components != from.components && from.components != 1)) return fail(in, "assign: a " + language::nameOf(symbol.type) + " cannot take such a value");
  const bool array = whole.elements > 1 || from.elements > 1;
  const uint32_t n = array ? std::min(whole.cells(), from.cells()) : whole.components;
  const uint32_t step = from.components > 1 || array ? 1 : 0;
  // straight into its place where that needs no blend
  if (whole.varies && !a_.blends(region_, to)) {
    copyCells(whole.reg, 0, from.reg, from.at, n, from.varies, step);
    if (!whole.derivs) return;
    if (!from.derivs) return clearDerivs(whole, false);
    const uint32_t all = registers_[size_t(from.reg)].cells / 3;
    for (uint32_t d = 1; d <= 2; ++d) copyCells(whole.reg, d * whole.cells(), from.reg, from.at + d * all, n, true, step);
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
  if (base == Base::Matrix && (kernel == Arithmetic::Mul || kernel == Arithmetic::Div)) return matrixArithmetic(in, a, b);
  const uint32_t n = uint32_t(componentsOf(base));
  if (!isFloatBased(base) || (a.components != n && a.components != 1) || (b.components != n && b.components != 1)) return fail(in, std::string(factsOf(in.opcode).name) + " does not take operands of these types");
  const Symbol& divisor = shader_.symbols[size_t(in.arguments[2])];
  if (kernel == Arithmetic::Div && divisor.kind == SymbolKind::Constant) {
    const bool plain = divisor.type.base == Base::Int ? divisor.values.ints[0] != 0 : std::none_of(divisor.values.floats.begin(), divisor.values.floats.end(), [](float f) { return f == 0; });
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
  if ((a.components != 16 && a.components != 1) || (b.components != 16 && b.components != 1)) return fail(in, "a matrix operation does not take operands of these types");
  if (b.components == 1 || (a.components == 1 && !division)) {
    const Target t = begin(in.arguments[0], !a.varies && !b.varies, {a, b});
    word(16);
    resultWords(t.out, false);
    plainWords(a, 16);
    plainWords(b, 16);
    emit(variant(division ? Arithmetic::Div : Arithmetic::Mul, t.once ? 0 : !a.varies ? 1 : !b.varies ? 2 : 0), t.once);
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
  if (a.components != n && a.components != 1) return fail(in, std::string(factsOf(in.opcode).name) + " does not take operands of these types");
  const Target t = begin(in.arguments[0], !a.varies, {a});
  const bool dual = hasDual && t.out.derivs && a.derivs;
  word(n);
  resultWords(t.out, dual);
  if (dual) dualWords(a, n);
  else plainWords(a, n);
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
    const bool asItIs = kernel == Mixed::SelectI && (k == 2 || shader_.symbols[size_t(in.arguments[0])].type.base == Base::Int || shader_.symbols[size_t(in.arguments[0])].type.base == Base::String);
    o[k] = asItIs ? operand(in.arguments[firstOperand + k]) : number(in.arguments[firstOperand + k]);
    if (o[k].components != n && o[k].components != 1) return fail(in, std::string(factsOf(in.opcode).name) + " does not take operands of these types");
    varies |= o[k].varies;
    derivs |= o[k].derivs;
  }
  const Target t = begin(in.arguments[0], !varies, {o[0], o[1], o[2], o[3]});
  const bool dual = t.out.derivs && derivs;
  word(n);
  resultWords(t.out, dual);
  for (uint32_t k = 0; k < operands; ++k) {
    if (dual) dualMixedWords(o[k], n);
    else mixedWords(o[k], n);
  }
  emit(variant(kernel, dual ? 1 : 0), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

void CodeGenerator::integers(const Instruction& in, Integer kernel) {
  const Operand a = operand(in.arguments[1]), b = operand(in.arguments[2]);
  if (a.base != Base::Int || b.base != Base::Int || shader_.symbols[size_t(in.arguments[0])].type.base != Base::Int) return fail(in, std::string(factsOf(in.opcode).name) + " takes integers");
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
  if ((a.components != n && a.components != 1) || (b.components != n && b.components != 1)) return fail(in, "a comparison does not take operands of these types");
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
    if (dual) dualMixedWords(o[k], 3);
    else mixedWords(o[k], 3);
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
  if (in.arguments.size() == 3 && shader_.symbols[size_t(in.arguments[1])].type.base == Base::Matrix) m = operand(in.arguments[1]);
  else if (in.arguments.size() == 3) m = matrixBetween(in, kNone, in.arguments[1]);
  else if (in.arguments.size() == 4) m = matrixBetween(in, in.arguments[1], in.arguments[2]);
  else return fail(in, "transform takes a matrix or one or two spaces");
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
  if (dual) dualMixedWords(v, 3);
  else mixedWords(v, 3);
  reference(m.reg, m.at);
  word(m.varies);
  emit(variant(kernel, dual ? 1 : 0), t.once);
  if (!dual) clearDerivs(t.out, t.once);
  finish(t);
}

// Work point by point: number of arguments, site, extra, has a mask, mask, then for each {cell, base | flags, cells, dx
// cell}; the kernel writes only points of the mask.
void CodeGenerator::scalar(const Instruction& in, Scalar kernel, std::string name, uint32_t extra) {
  bool varies = false;
  bool anyVaryingResult = false;
  for (uint32_t i = 0; i < in.arguments.size(); ++i) {
    const bool v = a_.isVarying[size_t(in.arguments[i])];
    const char access = accessOf(shader_, in, i);
    if (access != 'w') varies |= v;
    if (access != 'r') anyVaryingResult |= v;
  }
  const bool messages = in.opcode == Opcode::Printf || in.opcode == Opcode::Error || in.opcode == Opcode::Warning || in.opcode == Opcode::Fprintf || in.opcode == Opcode::Complain;
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
    word(uint32_t(o.base) | uint32_t(o.varies) << 8 | uint32_t(o.derivs) << 9 | uint32_t(shader_.symbols[size_t(s)].type.arrayLength != 0) << 10);
    word(o.cells());
    if (o.derivs) reference(o.reg, o.at + o.cells());
    else word(0);
  }
  emit(kernel, once);
  if (kernel == Scalar::Refuse && !in.arguments.empty() && accessOf(shader_, in, 0) == 'w') {  // the answer is nothing
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
    if (accessOf(shader_, in, i) == 'r' || !o.derivs || in.opcode == Opcode::Texture || in.opcode == Opcode::Texture3d || in.opcode == Opcode::Environment || in.opcode == Opcode::DebugUninit) continue;
    const Operand zero = constant(0.f);
    word(2 * o.cells());
    reference(o.reg, o.cells());
    reference(zero.reg);
    word(0);
    reference(maskOf(region_));
    emit(Memory::BlendUniform, false);
  }
}

void CodeGenerator::operation(const Instruction& in) {
  const auto base = [&](size_t i) { return shader_.symbols[size_t(in.arguments[i])].type.base; };
  switch (in.opcode) {
    case Opcode::Assign:
      if (const Instruction* maker = fused_[size_t(in.arguments[1])]) {
        Instruction made = *maker;
        made.arguments[0] = in.arguments[0];
        return operation(made);
      }
      return assign(in, in.arguments[0], operand(in.arguments[1]));
    case Opcode::ArrayCopy: return assign(in, in.arguments[0], operand(in.arguments[1]));
    case Opcode::ArrayRef:
      if (base(0) == Base::Closure) return;
      return arrayRead(in, in.arguments[0], operand(in.arguments[1]), operand(in.arguments[2]), nameOf(in));
    case Opcode::ArrayAssign:
      if (base(0) == Base::Closure) return;
      return arrayWrite(in, in.arguments[0], operand(in.arguments[0]), operand(in.arguments[1]), operand(in.arguments[2]), nameOf(in));
    case Opcode::ComponentRef:
    case Opcode::MatrixRef: return componentRead(in);
    case Opcode::ComponentAssign:
    case Opcode::MatrixAssign: return componentWrite(in);
    case Opcode::Add: return arithmetic(in, Arithmetic::Add, Integer::AddI);
    case Opcode::Sub: return arithmetic(in, Arithmetic::Sub, Integer::SubI);
    case Opcode::Mul: return arithmetic(in, Arithmetic::Mul, Integer::MulI);
    case Opcode::Div: return arithmetic(in, Arithmetic::Div, Integer::DivI);
    case Opcode::Min: return arithmetic(in, Arithmetic::Min, Integer::MinI);
    case Opcode::Max: return arithmetic(in, Arithmetic::Max, Integer::MaxI);
    case Opcode::Mod: return integers(in, Integer::ModI);
    case Opcode::FloorMod:
      if (base(0) == Base::Int) return integers(in, Integer::FloorModI);
      return mixed(in, Mixed::FloorMod, 1, 2);
    case Opcode::Neg:
      if (base(0) == Base::Int) return integerUnary(in, Integer::NegI);
      if (base(0) == Base::Closure) return;
      return unary(in, Math::Neg, true);
    case Opcode::BitAnd: return integers(in, Integer::AndBits);
    case Opcode::BitOr: return integers(in, Integer::OrBits);
    case Opcode::BitXor: return integers(in, Integer::XorBits);
    case Opcode::ShiftLeft: return integers(in, Integer::Shl);
    case Opcode::ShiftRight: return integers(in, Integer::Shr);
    case Opcode::Complement: return integerUnary(in, Integer::Complement);
    case Opcode::And: return integers(in, Integer::AndI);
    case Opcode::Or: return integers(in, Integer::OrI);
    case Opcode::Eq: return compare(in, Mixed::EqF, Mixed::EqI);
    case Opcode::Neq: return compare(in, Mixed::NeqF, Mixed::NeqI);
    case Opcode::Lt: return compare(in, Mixed::LtF, Mixed::LtI);
    case Opcode::Le: return compare(in, Mixed::LeF, Mixed::LeI);
    case Opcode::Gt: return compare(in, Mixed::GtF, Mixed::GtI);
    case Opcode::Ge: return compare(in, Mixed::GeF, Mixed::GeI);
    case Opcode::MakeColor:
    case Opcode::MakePoint:
    case Opcode::MakeVector:
    case Opcode::MakeNormal:
    case Opcode::MakeMatrix: return construct(in);
    case Opcode::MakeClosure: return;  // closures have no value here: patterns give numbers, materials are bxdfs
    case Opcode::Cos: return unary(in, Math::Cos, true);
    case Opcode::Sin: return unary(in, Math::Sin, true);
    case Opcode::Tan: return unary(in, Math::Tan, true);
    case Opcode::SinCos: {
      Instruction half = in;
      half.arguments = {in.arguments[1], in.arguments[0]};
      Instruction other = in;
      other.arguments = {in.arguments[2], in.arguments[0]};
      // the angle may be overwritten by the first result
      if (in.arguments[1] == in.arguments[0]) {
        unary(other, Math::Cos, true);
        return unary(half, Math::Sin, true);
      }
      unary(half, Math::Sin, true);
      return unary(other, Math::Cos, true);
    }
    case Opcode::Acos: return unary(in, Math::Acos, true);
    case Opcode::Asin: return unary(in, Math::Asin, true);
    case Opcode::Atan: return unary(in, Math::Atan, true);
    case Opcode::Atan2: return mixed(in, Mixed::Atan2, 1, 2);
    case Opcode::Cosh: return unary(in, Math::Cosh, true);
    case Opcode::Sinh: return unary(in, Math::Sinh, true);
    case Opcode::Tanh: return unary(in, Math::Tanh, true);
    case Opcode::Radians: return unary(in, Math::Radians, true);
    case Opcode::Degrees: return unary(in, Math::Degrees, true);
    case Opcode::Pow: return mixed(in, Mixed::Pow, 1, 2);
    case Opcode::Exp: return unary(in, Math::Exp, true);
    case Opcode::Exp2: return unary(in, Math::Exp2, true);
    case Opcode::Expm1: return unary(in, Math::Expm1, true);
    case Opcode::Log: {
      if (in.arguments.size() == 2) return unary(in, Math::Log, true);
      // log(x) / log(base), each into a value of its own
      const Operand x = number(in.arguments[1]), b = number(in.arguments[2]);
      Operand logs[2];
      const Operand* from[2] = {&x, &b};
      for (int k = 0; k < 2; ++k) {
        logs[k] = temporary(from[k]->base, from[k]->components, from[k]->varies, from[k]->derivs);
        word(from[k]->components);
        resultWords(logs[k], from[k]->derivs);
        if (from[k]->derivs) dualWords(*from[k], from[k]->components);
        else plainWords(*from[k], from[k]->components);
        emit(variant(Math::Log, from[k]->derivs ? 1 : 0), !from[k]->varies);
      }
      const uint32_t n = uint32_t(componentsOf(base(0)));
      const Target t = begin(in.arguments[0], !x.varies && !b.varies, {x, b});
      const bool dual = t.out.derivs && (x.derivs || b.derivs);
      word(n);
      resultWords(t.out, dual);
      for (const Operand& o : logs) {
        if (dual) dualWords(o, n);
        else plainWords(o, n);
      }
      emit(variant(Arithmetic::Div, (dual ? 3 : 0) + (t.once ? 0 : !x.varies ? 1 : !b.varies ? 2 : 0)), t.once);
      if (!dual) clearDerivs(t.out, t.once);
      return finish(t);
    }
    case Opcode::Log2: return unary(in, Math::Log2, true);
    case Opcode::Log10: return unary(in, Math::Log10, true);
    case Opcode::Logb: return unary(in, Math::Logb, false);
    case Opcode::Sqrt: return unary(in, Math::Sqrt, true);
    case Opcode::InverseSqrt: return unary(in, Math::InverseSqrt, true);
    case Opcode::Cbrt: return unary(in, Math::Cbrt, true);
    case Opcode::Abs:
    case Opcode::Fabs:
      if (base(0) == Base::Int) return integerUnary(in, Integer::AbsI);
      return unary(in, Math::Abs, true);
    case Opcode::Sign: return unary(in, Math::Sign, false);
    case Opcode::Floor: return unary(in, Math::Floor, false);
    case Opcode::Ceil: return unary(in, Math::Ceil, false);
    case Opcode::Round: return unary(in, Math::Round, false);
    case Opcode::Trunc: return unary(in, Math::Trunc, false);
    case Opcode::Fmod:
      return mixed(in, Mixed::Fmod, 1, 2);
    case Opcode::Step: return mixed(in, Mixed::Step, 1, 2);
    case Opcode::Clamp:
      if (base(0) == Base::Int) {
        Operand lowered = temporary(Base::Int, 1, a_.isVarying[size_t(in.arguments[1])] || a_.isVarying[size_t(in.arguments[3])]);
        word(1);
        resultWords(lowered, false);
        mixedWords(operand(in.arguments[1]), 1);
        mixedWords(operand(in.arguments[3]), 1);
        emit(Integer::MinI, !lowered.varies);
        const Operand low = operand(in.arguments[2]);
        const Target t = begin(in.arguments[0], !lowered.varies && !low.varies, {});
        word(1);
        resultWords(t.out, false);
        mixedWords(lowered, 1);
        mixedWords(low, 1);
        emit(Integer::MaxI, t.once);
        return finish(t);
      }
      return mixed(in, Mixed::Clamp, 1, 3);
    case Opcode::Mix:
      if (base(0) == Base::Closure) return;
      return mixed(in, Mixed::Mix, 1, 3);
    case Opcode::Select:
      if (choose(in)) return;
      if (base(3) == Base::Int && operand(in.arguments[3]).components == 1) return mixed(in, Mixed::SelectI, 1, 3);
      return mixed(in, Mixed::Select, 1, 3);
    case Opcode::SmoothStep: return mixed(in, Mixed::SmoothStep, 1, 3);
    case Opcode::LinearStep: return mixed(in, Mixed::LinearStep, 1, 3);
    case Opcode::SmoothLinearStep: return mixed(in, Mixed::SmoothLinearStep, 1, 4);
    case Opcode::IsNan: return integerUnary(in, Integer::IsNan);
    case Opcode::IsInf: return integerUnary(in, Integer::IsInf);
    case Opcode::IsFinite: return integerUnary(in, Integer::IsFinite);
    case Opcode::Erf: return unary(in, Math::Erf, true);
    case Opcode::Erfc: return unary(in, Math::Erfc, true);
    case Opcode::Cross: return vector(in, Vector::Cross, 2, true);
    case Opcode::Dot: return vector(in, Vector::Dot, 2, true);
    case Opcode::Length: return vector(in, Vector::Length, 1, true);
    case Opcode::Distance:
      return in.arguments.size() == 4 ? vector(in, Vector::SegmentDistance, 3, true) : vector(in, Vector::Distance, 2, true);
    case Opcode::Normalize: return vector(in, Vector::Normalize, 1, true);
    case Opcode::FaceForward: return vector(in, Vector::FaceForward, 3, true);
    case Opcode::Reflect: return vector(in, Vector::Reflect, 2, true);
    case Opcode::Refract: return vector(in, Vector::Refract, 3, true);
    case Opcode::Rotate: return vector(in, Vector::Rotate, 3, true);
    case Opcode::Determinant:
    case Opcode::Transpose: {
      const Operand m = asMatrix(operand(in.arguments[1]));
      const Target t = begin(in.arguments[0], !m.varies, {m}, false);
      resultWords(t.out, false);
      reference(m.reg, m.at);
      word(m.varies);
      emit(in.opcode == Opcode::Determinant ? Vector::MatrixDeterminant : Vector::MatrixTranspose, t.once);
      clearDerivs(t.out, t.once);
      return finish(t);
    }
    case Opcode::GetMatrix: {
      const bool two = in.arguments.size() == 4;
      matrixBetween(in, in.arguments[1], two ? in.arguments[2] : kNone);
      return;
    }
    case Opcode::TransformPoint: return transform(in, Vector::TransformPoint, false);
    case Opcode::TransformVector: return transform(in, Vector::TransformVector, false);
    case Opcode::TransformNormal: return transform(in, Vector::TransformNormal, true);
    case Opcode::DerivX: return derivative(in, 1);
    case Opcode::DerivY: return derivative(in, 2);
    case Opcode::DerivZ: return derivative(in, 3);
    case Opcode::FilterWidth:
    case Opcode::Area:
    case Opcode::CalculateNormal: return swept(in);
    case Opcode::Noise:
    case Opcode::SNoise:
    case Opcode::PNoise:
    case Opcode::PSNoise:
    case Opcode::CellNoise:
    case Opcode::HashNoise:
    case Opcode::Hash: return noise(in);
    case Opcode::Spline:
    case Opcode::SplineInverse: return spline(in);
    case Opcode::Luminance: return spectral(in, Spectral::Luminance);
    case Opcode::Blackbody: return spectral(in, Spectral::Blackbody);
    case Opcode::WavelengthColor: return spectral(in, Spectral::WavelengthColor);
    case Opcode::TransformColor: {
      const bool two = in.arguments.size() == 4;
      const std::string *from = two ? constantString(in.arguments[1]) : nullptr, *to = constantString(in.arguments[two ? 2 : 1]);
      if ((two && !from) || !to) return scalar(in, Scalar::Refuse, "a colour space that is not known before the run");
      return transformColor(in, in.arguments[0], number(in.arguments.back()), from, to, false);
    }
    case Opcode::Printf: return scalar(in, Scalar::Printf, {}, uint32_t(MessageKind::Printf));
    case Opcode::Error: return scalar(in, Scalar::Printf, {}, uint32_t(MessageKind::Error));
    case Opcode::Warning: return scalar(in, Scalar::Printf, {}, uint32_t(MessageKind::Warning));
    case Opcode::Fprintf: return scalar(in, Scalar::Printf, {}, uint32_t(MessageKind::File));
    case Opcode::Format: return scalar(in, Scalar::Format);
    case Opcode::Concat: return scalar(in, Scalar::Concat);
    case Opcode::Strlen: return scalar(in, Scalar::Strlen);
    case Opcode::GetChar: return scalar(in, Scalar::GetChar);
    case Opcode::StartsWith: return scalar(in, Scalar::StartsWith);
    case Opcode::EndsWith: return scalar(in, Scalar::EndsWith);
    case Opcode::Substr: return scalar(in, Scalar::Substr);
    case Opcode::StoI: return scalar(in, Scalar::StoI);
    case Opcode::StoF: return scalar(in, Scalar::StoF);
    case Opcode::Split: return scalar(in, Scalar::Split);
    case Opcode::Complain: return scalar(in, Scalar::Printf, {}, uint32_t(MessageKind::Error) | 256);
    case Opcode::DebugNan: return scalar(in, Scalar::DebugNan);
    case Opcode::DebugUninit: return scalar(in, Scalar::DebugUninit);
    case Opcode::RegexSearch: return scalar(in, Scalar::Regex, {}, 0);
    case Opcode::RegexMatch: return scalar(in, Scalar::Regex, {}, 1);
    case Opcode::Trace: return scalar(in, Scalar::Trace);
    case Opcode::GetMessage: return in.arguments.size() == 4 ? scalar(in, Scalar::GetMessage) : scalar(in, Scalar::Refuse, "a message of a name that is not known before the run");
    case Opcode::SetMessage: return scalar(in, Scalar::Refuse, "a message of a name that is not known before the run");
    case Opcode::DictFind: return scalar(in, Scalar::DictFind);
    case Opcode::DictNext: return scalar(in, Scalar::DictNext);
    case Opcode::DictValue: return scalar(in, Scalar::DictValue);
    case Opcode::GetAttribute: return scalar(in, Scalar::GetAttribute);
    case Opcode::RayType: return scalar(in, Scalar::RayType);
    case Opcode::Backfacing: return scalar(in, Scalar::Backfacing);
    case Opcode::SurfaceArea: return scalar(in, Scalar::SurfaceArea);
    case Opcode::Texture: return scalar(in, Scalar::Texture, {}, uint32_t(TextureKind::Texture));
    case Opcode::Texture3d: return scalar(in, Scalar::Texture, {}, uint32_t(TextureKind::Texture3d));
    case Opcode::Environment: return scalar(in, Scalar::Texture, {}, uint32_t(TextureKind::Environment));
    case Opcode::GetTextureInfo: return scalar(in, Scalar::GetTextureInfo);
    case Opcode::IsConstant: {
      const bool constant = shader_.symbols[size_t(in.arguments[1])].kind == SymbolKind::Constant;
      return assign(in, in.arguments[0], constantInt(constant));
    }
    default: break;
  }
  return scalar(in, Scalar::Refuse, std::string(factsOf(in.opcode).name));
}

}  // namespace kinora::language

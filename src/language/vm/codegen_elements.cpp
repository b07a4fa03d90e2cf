// Values made of parts: constructors of triples and matrices, components, elements of arrays.
#include <algorithm>

#include "language/vm/codegen.h"

namespace kinora::language {

namespace {

// What a constructor makes. Its result may stand in a variable of another triple, which has no say in what becomes of
// a space.
Base madeBy(Opcode op) {
  return op == Opcode::MakeColor    ? Base::Color
         : op == Opcode::MakePoint  ? Base::Point
         : op == Opcode::MakeVector ? Base::Vector
         : op == Opcode::MakeNormal ? Base::Normal
                                    : Base::Matrix;
}

}  // namespace

// color, point, vector, normal, matrix: from a number, from components; with a space in front.
void CodeGenerator::construct(const Instruction& in) {
  const SymbolId result = in.arguments[0];
  const Base base = madeBy(in.opcode);
  uint32_t first = 1;
  const bool spaced = in.arguments.size() > 1 && shader_.symbols[size_t(in.arguments[1])].type.base == Base::String;
  if (spaced) ++first;
  const uint32_t n = uint32_t(componentsOf(base)), given = uint32_t(in.arguments.size()) - first;
  if (base == Base::Matrix && spaced && given == 1 &&
      shader_.symbols[size_t(in.arguments[2])].type.base == Base::String) {
    const Operand m = matrixBetween(in, in.arguments[1], in.arguments[2]);
    return assign(in, result, m);
  }
  if (given != n && given != 1) return fail(in, "a constructor takes one value or one for each component");
  std::vector<Operand> parts;
  bool varies = false, derivs = false;
  for (uint32_t k = 0; k < given; ++k) {
    Operand o = number(in.arguments[first + k]);
    if (o.components != 1) {
      if (given != 1 || o.components != n) return fail(in, "a constructor takes numbers");
    }
    parts.push_back(o);
    varies |= o.varies;
    derivs |= o.derivs;
  }
  if (given == 1 && n == 16) parts[0] = asMatrix(parts[0]);
  // gathered into a temporary where the place may be read meanwhile or must be blended
  Operand made;
  const Operand whole = operand(result);
  bool direct = !spaced && whole.varies == varies && !(whole.varies && a_.blends(region_, result));
  for (const Operand& o : parts) direct &= o.reg != whole.reg;
  made = direct ? whole : temporary(base, n, varies, varies && whole.derivs && derivs);
  for (uint32_t k = 0; k < n; ++k) {
    const Operand o = parts[given == 1 ? 0 : k];
    const uint32_t at = o.at + (o.components > 1 ? k : 0);
    copyCells(made.reg, k, o.reg, at, 1, o.varies, 0);
    if (!made.derivs) continue;
    for (uint32_t d = 1; d <= 2; ++d) {
      if (o.derivs)
        copyCells(made.reg, d * n + k, o.reg, at + d * (registers_[size_t(o.reg)].cells / 3), 1, true, 0);
      else
        copyCells(made.reg, d * n + k, zeros(), 0, 1, true, 0);
    }
  }
  if (direct) return;
  if (!spaced) return assign(in, result, made);
  if (base == Base::Color) {
    const std::string* space = constantString(in.arguments[1]);
    if (!space) return scalar(in, Scalar::Refuse, "a colour space that is not known before the run");
    return transformColor(in, result, made, space, nullptr, true);
  }
  const Operand matrix = matrixBetween(in, in.arguments[1], kNone);
  if (base == Base::Matrix) {  // space to common, then the given matrix
    Operand out = temporary(Base::Matrix, 16, true);
    reference(out.reg);
    for (const Operand& o : {matrix, made}) {
      reference(o.reg, o.at);
      word(o.varies);
    }
    emit(Vector::MatrixMul, false);
    return assign(in, result, out);
  }
  Operand m = matrix;
  if (base == Base::Normal) {
    m = temporary(Base::Matrix, 16, true);
    reference(m.reg);
    reference(matrix.reg);
    word(matrix.varies);
    emit(Vector::MatrixInverse, false);
  }
  const Operand out = temporary(base, 3, true, made.derivs);
  resultWords(out, made.derivs);
  if (made.derivs)
    dualMixedWords(made, 3);
  else
    mixedWords(made, 3);
  reference(m.reg);
  word(m.varies);
  const Vector kernel = base == Base::Point    ? Vector::TransformPoint
                        : base == Base::Vector ? Vector::TransformVector
                                               : Vector::TransformNormal;
  emit(variant(kernel, made.derivs), false);
  assign(in, result, out);
}

CodeGenerator::Operand CodeGenerator::checkedIndex(const Instruction& in, Operand index, uint32_t length,
                                                   const std::string& name) {
  Operand made = temporary(Base::Int, 1, index.varies);
  word(site(in, name));
  reference(made.reg);
  reference(index.reg, index.at);
  word(index.varies);
  word(length);
  const Register mask = maskOf(region_);
  word(mask != rootMask_);
  if (mask != rootMask_) reference(mask);
  emit(Scalar::CheckIndex, !index.varies);
  return made;
}

// words: elements, components of one, result, array, array varies, index, index varies
void CodeGenerator::arrayRead(const Instruction& in, SymbolId result, Operand array, Operand index,
                              const std::string& name) {
  index = checkedIndex(in, index, array.elements, name);
  const uint32_t n = array.components;
  const bool varies = array.varies || index.varies;
  const Symbol& symbol = shader_.symbols[size_t(result)];
  Operand out = temporary(array.base, n, varies, array.derivs && operand(result).derivs);
  if (symbol.type.base == array.base && !varies == !operand(result).varies && !a_.blends(region_, result) &&
      operand(result).reg != array.reg && out.derivs == operand(result).derivs)
    out = operand(result);
  const uint32_t third = registers_[size_t(array.reg)].cells / (array.derivs ? 3 : 1);
  for (uint32_t d = 0; d < (out.derivs ? 3u : 1u); ++d) {
    word(n);
    reference(out.reg, d * n);
    reference(array.reg, array.at + d * third);
    word(array.varies);
    reference(index.reg, index.at);
    word(index.varies);
    emit(Scalar::ArrayRead, !varies);
  }
  if (out.reg != operand(result).reg) assign(in, result, out);
}

// words: components of one element, array, value, its step, value varies, index, index varies, has a mask, mask
void CodeGenerator::arrayWrite(const Instruction& in, SymbolId array, Operand whole, Operand index, Operand value,
                               const std::string& name) {
  index = checkedIndex(in, index, whole.elements, name);
  if (whole.base == Base::Int ? value.base != Base::Int
                              : (whole.base == Base::String) != (value.base == Base::String))
    return fail(in, "an element cannot take a value of this type");
  if (whole.base != Base::Int) value = asFloat(value);
  const bool blends = a_.blends(region_, array);
  const uint32_t third = registers_[size_t(whole.reg)].cells / (whole.derivs ? 3 : 1);
  for (uint32_t d = 0; d < (whole.derivs ? 3u : 1u); ++d) {
    word(whole.components);
    reference(whole.reg, whole.at + d * third);
    if (d && !value.derivs)
      reference(zeros());
    else
      reference(value.reg, value.at + d * (registers_[size_t(value.reg)].cells / 3));
    word(value.components > 1 && !(d && !value.derivs));
    word(d && !value.derivs ? 1 : value.varies);
    reference(index.reg, index.at);
    word(index.varies);
    word(blends);
    if (blends) reference(maskOf(region_));
    emit(Scalar::ArrayWrite, !whole.varies);
  }
}

// row * 4 + column of checked indices.
CodeGenerator::Operand CodeGenerator::matrixIndex(const Instruction& in, SymbolId row, SymbolId column,
                                                  const std::string& name) {
  const Operand r = checkedIndex(in, operand(row), 4, name), c = checkedIndex(in, operand(column), 4, name);
  const Operand four = constantInt(4), scaled = temporary(Base::Int, 1, r.varies),
                sum = temporary(Base::Int, 1, r.varies || c.varies);
  word(1);
  resultWords(scaled, false);
  mixedWords(r, 1);
  mixedWords(four, 1);
  emit(Integer::MulI, !r.varies);
  word(1);
  resultWords(sum, false);
  mixedWords(scaled, 1);
  mixedWords(c, 1);
  emit(Integer::AddI, !sum.varies);
  return sum;
}

void CodeGenerator::componentRead(const Instruction& in) {
  const Operand from = operand(in.arguments[1]);
  const bool matrix = in.opcode == Opcode::MatrixRef;
  int32_t row = 0, column = 0;
  const std::string name = nameOf(in);
  if (matrix && constantInt(in.arguments[2], row) && constantInt(in.arguments[3], column) && row >= 0 && row < 4 &&
      column >= 0 && column < 4)
    return assign(in, in.arguments[0], part(from, uint32_t(row * 4 + column)));
  if (!matrix && constantInt(in.arguments[2], column) && column >= 0 && column < int32_t(from.components)) {
    Operand one = part(from, uint32_t(column));
    one.base = Base::Float;
    return assign(in, in.arguments[0], one);
  }
  Operand cells = from;
  cells.base = Base::Float;
  cells.elements = from.components;
  cells.components = 1;
  if (!matrix) return arrayRead(in, in.arguments[0], cells, operand(in.arguments[2]), name);
  arrayRead(in, in.arguments[0], cells, matrixIndex(in, in.arguments[2], in.arguments[3], name), name);
}

void CodeGenerator::componentWrite(const Instruction& in) {
  const SymbolId target = in.arguments[0];
  const Operand whole = operand(target);
  const bool matrix = in.opcode == Opcode::MatrixAssign;
  const std::string name = nameOf(in);
  const Operand value = number(in.arguments[matrix ? 3 : 2]);
  int32_t row = 0, column = 0;
  const bool known = matrix
                         ? constantInt(in.arguments[1], row) && constantInt(in.arguments[2], column) && row >= 0 &&
                               row < 4 && column >= 0 && column < 4
                         : constantInt(in.arguments[1], column) && column >= 0 && column < int32_t(whole.components);
  if (known && !(whole.varies && a_.blends(region_, target))) {
    const uint32_t at = uint32_t(row * 4 + column), all = whole.cells();
    copyCells(whole.reg, at, value.reg, value.at, 1, value.varies, 0);
    if (whole.derivs)
      for (uint32_t d = 1; d <= 2; ++d) {
        if (value.derivs)
          copyCells(whole.reg, at + d * all, value.reg, value.at + d * (registers_[size_t(value.reg)].cells / 3), 1,
                    true, 0);
        else
          copyCells(whole.reg, at + d * all, zeros(), 0, 1, true, 0);
      }
    return;
  }
  Operand cells = whole;
  cells.elements = whole.components;
  cells.components = 1;
  cells.base = Base::Float;
  const Operand index = matrix ? matrixIndex(in, in.arguments[1], in.arguments[2], name) : operand(in.arguments[1]);
  arrayWrite(in, target, cells, index, value, name);
}

}  // namespace kinora::language

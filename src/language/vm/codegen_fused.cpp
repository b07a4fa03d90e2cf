// Which operations are done together with the one that reads them, and the instructions for that. A value joins its
// reader when nobody else reads it, when it stands in the same block of code before it, and when nothing between the
// two changes what it is made from. Values that cost less to make again than to keep join several readers.
#include "language/optimise/walk.h"
#include "language/vm/codegen.h"

namespace kinora::language {

namespace {

constexpr size_t kFarthest = 32;  // instructions between a value and its reader that are looked through
constexpr uint32_t kMostReaders = 4;

bool isComparison(Opcode op) {
  return op == Opcode::Eq || op == Opcode::Neq || op == Opcode::Lt || op == Opcode::Le || op == Opcode::Gt ||
         op == Opcode::Ge;
}
bool isArithmetic(Opcode op) {
  return op == Opcode::Add || op == Opcode::Sub || op == Opcode::Mul || op == Opcode::Div;
}

}  // namespace

// A comparison of two numbers of one kind, at least one of which varies.
bool CodeGenerator::isCondition(const Instruction& in) const {
  if (!isComparison(in.opcode)) return false;
  const Symbol &a = shader_.symbols[size_t(in.arguments[1])], &b = shader_.symbols[size_t(in.arguments[2])];
  if (a.type.base != b.type.base || (a.type.base != Base::Int && a.type.base != Base::Float)) return false;
  return a_.isVarying[size_t(in.arguments[1])] || a_.isVarying[size_t(in.arguments[2])];
}

// Whether anything from `maker` to `reader` writes what `in` reads, or what those read that joined it.
bool CodeGenerator::isChangedBetween(const Block& code, size_t maker, size_t reader, const Instruction& in) const {
  for (size_t m = 1; m < in.arguments.size(); ++m) {
    const SymbolId operand = in.arguments[m];
    if (const Instruction* inner = fused_[size_t(operand)]; inner && isChangedBetween(code, maker, reader, *inner))
      return true;
    for (size_t k = maker + 1; k < reader; ++k)
      for (uint32_t n = 0; n < code.code[k].arguments.size(); ++n)
        if (code.code[k].arguments[n] == operand && accessOf(shader_, code.code[k], n) != 'r') return true;
  }
  return false;
}

// What makes `s` for `reader` and as many readers as are given in all.
const Instruction* CodeGenerator::makerOf(const Block& code, size_t reader, SymbolId s, uint32_t readers) const {
  const Symbol& symbol = shader_.symbols[size_t(s)];
  if (uses_[size_t(s)].reads != readers || uses_[size_t(s)].writes != 1 ||
      (symbol.kind != SymbolKind::Local && symbol.kind != SymbolKind::Temp) || symbol.type.arrayLength != 0)
    return nullptr;
  if (!a_.isVarying[size_t(s)] || a_.hasDerivs[size_t(s)] || a_.needsZero[size_t(s)]) return nullptr;
  const size_t last = reader > kFarthest ? reader - kFarthest : 0;
  for (size_t i = reader; i-- > last;) {
    const Instruction& in = code.code[i];
    if (!in.blocks.empty()) return nullptr;
    if (in.arguments.empty() || in.arguments[0] != s) continue;
    if (!isArithmetic(in.opcode) && !isComparison(in.opcode) && in.opcode != Opcode::And &&
        in.opcode != Opcode::Select)
      return nullptr;
    return isChangedBetween(code, i, reader, in) ? nullptr : &in;
  }
  return nullptr;
}

// (a op b) op c of floats or triples without derivatives.
bool CodeGenerator::joins(const Instruction& maker, const Instruction& reader) const {
  if (!isArithmetic(maker.opcode) || maker.opcode == Opcode::Div || !isArithmetic(reader.opcode) ||
      reader.arguments[1] == reader.arguments[2])
    return false;
  if (reader.opcode == Opcode::Div && reader.arguments[1] != maker.arguments[0]) return false;
  for (const SymbolId s : {maker.arguments[1], maker.arguments[2], reader.arguments[1], reader.arguments[2]})
    if (fused_[size_t(s)]) return false;  // one of them has joined with another already
  const SymbolId result = reader.arguments[0], made = maker.arguments[0];
  const int32_t n = componentsOf(shader_.symbols[size_t(result)].type.base);
  if (!isFloatBased(shader_.symbols[size_t(result)].type.base) || n > 3 || a_.hasDerivs[size_t(result)]) return false;
  const auto fits = [&](SymbolId s) {
    const Symbol& symbol = shader_.symbols[size_t(s)];
    const int32_t m = componentsOf(symbol.type.base);
    return isFloatBased(symbol.type.base) && symbol.type.arrayLength == 0 && (m == n || m == 1);
  };
  if (componentsOf(shader_.symbols[size_t(made)].type.base) != n) return false;
  if (!a_.isVarying[size_t(maker.arguments[1])] && !a_.isVarying[size_t(maker.arguments[2])]) return false;
  for (size_t k = 1; k < 3; ++k)
    if (!fits(maker.arguments[k]) || !fits(reader.arguments[k])) return false;
  return true;
}

// A varying number and a uniform one: its readers load no more when they make the value themselves.
bool CodeGenerator::joinsAll(const Block& code, size_t maker) const {
  const Instruction& in = code.code[maker];
  if (!isArithmetic(in.opcode)) return false;
  const SymbolId s = in.arguments[0];
  const uint32_t readers = uses_[size_t(s)].reads;
  if (readers < 2 || readers > kMostReaders ||
      a_.isVarying[size_t(in.arguments[1])] == a_.isVarying[size_t(in.arguments[2])])
    return false;
  uint32_t found = 0;
  for (size_t j = maker + 1; j < std::min(code.code.size(), maker + kFarthest) && found < readers; ++j)
    for (size_t k = 1; k < code.code[j].arguments.size(); ++k) {
      if (code.code[j].arguments[k] != s) continue;
      if (!joins(in, code.code[j]) || makerOf(code, j, s, readers) != &in) return false;
      ++found;
    }
  return found == readers;
}

void CodeGenerator::findFused(const Block& code) {
  const auto join = [&](const Instruction& maker) { fused_[size_t(maker.arguments[0])] = &maker; };
  const auto isPlain = [&](SymbolId s) { return shader_.symbols[size_t(s)].type.arrayLength == 0; };
  for (size_t j = 0; j < code.code.size(); ++j) {
    const Instruction& in = code.code[j];
    for (const Block& inner : in.blocks) findFused(inner);
    if (isArithmetic(in.opcode)) {
      for (const size_t k : {size_t(1), size_t(2)}) {
        const Instruction* maker = makerOf(code, j, in.arguments[k]);
        if (!maker || !joins(*maker, in)) continue;
        join(*maker);
        break;
      }
      if (joinsAll(code, j) && !fused_[size_t(in.arguments[1])] && !fused_[size_t(in.arguments[2])]) join(in);
    } else if (in.opcode == Opcode::Assign) {  // what was made to be copied is made in its place
      const Instruction* maker = makerOf(code, j, in.arguments[1]);
      if (maker && isArithmetic(maker->opcode) &&
          shader_.symbols[size_t(in.arguments[0])].type == shader_.symbols[size_t(in.arguments[1])].type &&
          !a_.hasDerivs[size_t(in.arguments[0])])
        join(*maker);
    } else if (in.opcode == Opcode::Select || in.opcode == Opcode::If) {
      const size_t asked = in.opcode == Opcode::If ? 0 : 3;
      const Instruction* maker = makerOf(code, j, in.arguments[asked]);
      if (!maker || !isCondition(*maker)) continue;
      if (in.opcode == Opcode::Select) {
        const Symbol &r = shader_.symbols[size_t(in.arguments[0])], &a = shader_.symbols[size_t(in.arguments[1])],
                     &b = shader_.symbols[size_t(in.arguments[2])];
        const auto fits = [&](const Symbol& s) {
          return s.type.arrayLength == 0 &&
                 (isFloatBased(r.type.base)
                      ? isFloatBased(s.type.base) &&
                            (componentsOf(s.type.base) == componentsOf(r.type.base) || componentsOf(s.type.base) == 1)
                      : s.type.base == r.type.base && componentsOf(s.type.base) == 1);
        };
        if (a_.hasDerivs[size_t(in.arguments[0])] || !isPlain(in.arguments[0]) || !fits(a) || !fits(b)) continue;
        join(*maker);
        // c ? x : (d ? y : z)
        const Instruction* inner = in.arguments[1] == in.arguments[2] ? nullptr : makerOf(code, j, in.arguments[1]);
        if (inner && inner->opcode == Opcode::Select && fused_[size_t(inner->arguments[3])] &&
            !fused_[size_t(inner->arguments[1])] && int(conditionOf(*maker)) < kOrders &&
            int(conditionOf(*fused_[size_t(inner->arguments[3])])) < kOrders &&
            componentsOf(a.type.base) == componentsOf(r.type.base))
          join(*inner);
        continue;
      }
      join(*maker);
    } else if (isLoop(in.opcode)) {
      // a loop's points are narrowed by each condition that must hold, one after the other
      const Block& test = in.blocks[1];
      std::vector<SymbolId> asked{in.arguments[0]};
      const size_t end = test.code.size();
      while (!asked.empty()) {
        const SymbolId s = asked.back();
        asked.pop_back();
        const Instruction* maker = makerOf(test, end, s);
        if (!maker) continue;
        if (isCondition(*maker)) {
          join(*maker);
        } else if (maker->opcode == Opcode::And && a_.isVarying[size_t(maker->arguments[1])] &&
                   a_.isVarying[size_t(maker->arguments[2])]) {
          const Base left = shader_.symbols[size_t(maker->arguments[1])].type.base,
                     right = shader_.symbols[size_t(maker->arguments[2])].type.base;
          if (left != Base::Int || right != Base::Int) continue;
          join(*maker);
          asked.push_back(maker->arguments[1]);
          asked.push_back(maker->arguments[2]);
        }
      }
    }
  }
}

void CodeGenerator::findFused() {
  fused_.assign(shader_.symbols.size(), nullptr);
  if (!options_.optimise) return;
  uses_.assign(shader_.symbols.size(), {});
  const auto use = [&](SymbolId s, char access) {
    if (access != 'w') ++uses_[size_t(s)].reads;
    if (access != 'r') ++uses_[size_t(s)].writes;
  };
  forEachInstruction(shader_.main, [&](const Instruction& in) {
    for (uint32_t k = 0; k < in.arguments.size(); ++k)
      if (in.arguments[k] >= 0) use(in.arguments[k], accessOf(shader_, in, k));
  });
  for (const Output& output : flat_.outputs) use(output.symbol, 'W');
  findFused(shader_.main);
}

Condition CodeGenerator::conditionOf(const Instruction& in) const {
  const bool ints = shader_.symbols[size_t(in.arguments[1])].type.base == Base::Int;
  switch (in.opcode) {
    case Opcode::Eq:
      return ints ? Condition::EqI : Condition::EqF;
    case Opcode::Neq:
      return ints ? Condition::NeqI : Condition::NeqF;
    case Opcode::Lt:
    case Opcode::Gt:
      return ints ? Condition::LtI : Condition::LtF;
    default:
      return ints ? Condition::LeI : Condition::LeF;
  }
}
// {a, varies, b, varies}
void CodeGenerator::conditionWords(const Instruction& in) {
  Operand a = operand(in.arguments[1]), b = operand(in.arguments[2]);
  if (in.opcode == Opcode::Gt || in.opcode == Opcode::Ge) std::swap(a, b);
  for (const Operand& o : {a, b}) {
    reference(o.reg, o.at);
    word(o.varies);
  }
}

// Takes the points where a condition does not hold from a region's mask; `any` becomes the chunks of those left.
void CodeGenerator::narrowMask(SymbolId condition, int32_t region, Register any) {
  const Instruction* test = fused_[size_t(condition)];
  if (test && test->opcode == Opcode::And) {
    const Instruction *left = fused_[size_t(test->arguments[1])], *right = fused_[size_t(test->arguments[2])];
    const auto isOrder = [&](const Instruction* in) {
      return in && in->opcode != Opcode::And && int(conditionOf(*in)) < kOrders;
    };
    if (isOrder(left) && isOrder(right)) {
      reference(masks_[size_t(region)]);
      reference(any);
      conditionWords(*left);
      conditionWords(*right);
      emit(Fused(int(Fused::NarrowTwice) + int(conditionOf(*left)) * kOrders + int(conditionOf(*right))), false);
      return;
    }
    narrowMask(test->arguments[1], region, any);
    return narrowMask(test->arguments[2], region, any);
  }
  const Operand asked = test ? Operand() : asInt(operand(condition));
  reference(masks_[size_t(region)]);
  if (test) {
    reference(any);
    conditionWords(*test);
    emit(Fused(int(Fused::Narrow) + int(conditionOf(*test))), false);
    return;
  }
  reference(asked.reg, asked.at);
  reference(any);
  emit(Memory::MaskAnd, false);
}

bool CodeGenerator::pair(const Instruction& in, Arithmetic kernel) {
  const bool second = fused_[size_t(in.arguments[2])] != nullptr;
  const Instruction* maker = fused_[size_t(in.arguments[second ? 2 : 1])];
  if (!maker) return false;
  Operand a = operand(maker->arguments[1]), b = operand(maker->arguments[2]);
  const Operand c = operand(in.arguments[second ? 1 : 2]);
  PairFirst first = maker->opcode == Opcode::Add   ? PairFirst::Add
                    : maker->opcode == Opcode::Mul ? PairFirst::Mul
                                                   : PairFirst::Sub;
  if (first == PairFirst::Sub) {
    if (!a.varies)
      first = PairFirst::SubUV;
    else if (!b.varies)
      first = PairFirst::SubVU;
  } else if (!a.varies || !b.varies) {
    if (!a.varies) std::swap(a, b);
    first = PairFirst(int(first) + 1);
  }
  const PairSecond then = kernel == Arithmetic::Add   ? PairSecond::Add
                          : kernel == Arithmetic::Mul ? PairSecond::Mul
                          : kernel == Arithmetic::Div ? PairSecond::Div
                          : second                    ? PairSecond::SubFrom
                                                      : PairSecond::Sub;
  const Target t = begin(in.arguments[0], false, {a, b, c});
  const uint32_t n = t.final.components;
  word(n);
  resultWords(t.final, false);
  for (const Operand& o : {a, b, c}) plainWords(o, n);
  if (t.blends) reference(maskOf(region_));
  emit(Fused(((int(first) * int(PairSecond::Count) + int(then)) * 2 + (c.varies ? 0 : 1)) * 2 + (t.blends ? 1 : 0)),
       false);
  return true;
}

bool CodeGenerator::choose(const Instruction& in) {
  const Instruction* test = fused_[size_t(in.arguments[3])];
  if (!test) return false;
  const Instruction* inner = fused_[size_t(in.arguments[1])];
  const Operand yes = operand(in.arguments[2]);
  const Target t = begin(in.arguments[0], false, {yes});
  const uint32_t n = t.final.components;
  word(n);
  resultWords(t.out, false);
  conditionWords(*test);
  int kernel = int(Fused::Choose) + int(conditionOf(*test));
  if (inner) {
    const Instruction& innerTest = *fused_[size_t(inner->arguments[3])];
    kernel = int(Fused::ChooseTwice) + int(conditionOf(*test)) * kOrders + int(conditionOf(innerTest));
    conditionWords(innerTest);
    mixedWords(operand(inner->arguments[1]), n);
    mixedWords(operand(inner->arguments[2]), n);
  } else {
    mixedWords(operand(in.arguments[1]), n);
  }
  mixedWords(yes, n);
  emit(Fused(kernel), false);
  finish(t);
  return true;
}

}  // namespace kinora::language

#include "language/optimise/optimise.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <unordered_map>

#include "language/optimise/fold.h"
#include "language/optimise/liveness.h"
#include "language/optimise/walk.h"

namespace kinora::language {

namespace {

bool isFloat(Base b) { return b == Base::Float || isTriple(b); }
bool isJump(Opcode op) {
  return op == Opcode::Break || op == Opcode::Continue || op == Opcode::Return || op == Opcode::Exit;
}

// ---- calls that nothing leaves early become plain code ----
bool leavesEarly(const Block& block, bool isLayer, bool nested) {
  for (const Instruction& in : block.code) {
    if (in.opcode == Opcode::Return && !nested) return true;
    if (in.opcode == Opcode::Exit && isLayer) return true;
    const bool call = in.opcode == Opcode::Call;
    if (call && in.arguments.size() == 2) continue;  // a layer keeps its exits to itself
    for (const Block& inner : in.blocks)
      if (leavesEarly(inner, isLayer, nested || call)) return true;
  }
  return false;
}
void open(Block& block) {
  std::vector<Instruction> made;
  made.reserve(block.code.size());
  for (Instruction& in : block.code) {
    for (Block& inner : in.blocks) open(inner);
    if (in.opcode == Opcode::Call) {
      auto& code = in.blocks[0].code;
      // an end at the very end is no early one
      while (!code.empty() && (code.back().opcode == Opcode::Return ||
                               (code.back().opcode == Opcode::Exit && in.arguments.size() == 2)))
        code.pop_back();
      if (!leavesEarly(in.blocks[0], in.arguments.size() == 2, false)) {
        std::move(code.begin(), code.end(), std::back_inserter(made));
        continue;
      }
    }
    const bool ends = isJump(in.opcode);
    made.push_back(std::move(in));
    if (ends) break;  // nothing behind it runs
  }
  block.code = std::move(made);
}

// ---- a branch that only picks one of two values becomes a select ----
void pickInstead(const Shader& shader, Block& block) {
  for (Instruction& in : block.code) {
    for (Block& inner : in.blocks) pickInstead(shader, inner);
    if (in.opcode != Opcode::If || in.blocks.empty()) continue;
    const auto& yes = in.blocks[0].code;
    const bool two = in.blocks.size() > 1 && !in.blocks[1].code.empty();
    const Symbol& condition = shader.symbols[size_t(in.arguments[0])];
    if (yes.size() != 1 || yes[0].opcode != Opcode::Assign || condition.type.base != Base::Int ||
        condition.type.arrayLength)
      continue;
    if (two && (in.blocks[1].code.size() != 1 || in.blocks[1].code[0].opcode != Opcode::Assign ||
                in.blocks[1].code[0].arguments[0] != yes[0].arguments[0]))
      continue;
    const SymbolId to = yes[0].arguments[0], a = yes[0].arguments[1],
                   b = two ? in.blocks[1].code[0].arguments[1] : to;
    const auto fits = [&](SymbolId s) {
      const Type &from = shader.symbols[size_t(s)].type, &type = shader.symbols[size_t(to)].type;
      if (from.arrayLength || type.arrayLength || componentsOf(type.base) == 16) return false;
      if (from.base == type.base || (isTriple(from.base) && isTriple(type.base))) return componentsOf(type.base) > 0;
      return isFloat(type.base) && (from.base == Base::Float || from.base == Base::Int);
    };
    if (!fits(a) || !fits(b)) continue;
    Instruction made;
    made.opcode = Opcode::Select;
    made.arguments = {to, b, a, in.arguments[0]};
    made.pos = in.pos;
    made.layer = in.layer;
    in = std::move(made);
  }
}

// ---- copies followed forwards, constants folded, conditions decided ----
class Propagation {
 public:
  explicit Propagation(FlatProgram& flat)
      : flat_(flat), shader_(flat.code), pool_(flat.code), folder_(flat.code, pool_) {
    value_.assign(shader_.symbols.size(), {});
    version_.assign(shader_.symbols.size(), 0);
    countWrites();
  }
  bool run() {
    block(shader_.main);
    return changed_;
  }

 private:
  // What a symbol held at one time; over when it is written again.
  struct Value {
    SymbolId is = kNone;
    uint32_t version = 0;
  };
  struct Known {
    Value same;  // as this symbol's
    // whose derivatives differ from this one's at most in the sign of a zero; isFlat: they are zero
    Value slopes;
    bool isFlat = false;
  };
  Value now(SymbolId s) const { return {s, version_[size_t(s)]}; }
  bool holds(const Value& v) const { return v.is != kNone && version_[size_t(v.is)] == v.version; }
  void grow() {
    value_.resize(shader_.symbols.size());
    version_.resize(shader_.symbols.size(), 0);
  }
  void countWrites() {
    writes_.assign(shader_.symbols.size(), 0);
    forEachInstruction(shader_.main, [&](const Instruction& in) {
      for (uint32_t i = 0; i < in.arguments.size(); ++i)
        if (accessOf(shader_, in, i) != 'r') ++writes_[size_t(in.arguments[i])];
    });
  }
  void set(SymbolId s, Known known) {
    undo_.emplace_back(s, value_[size_t(s)]);
    value_[size_t(s)] = known;
  }
  void written(SymbolId s) {
    set(s, {});
    ++version_[size_t(s)];
  }
  void killWrites(const Block& block) {
    forEachInstruction(block, [&](const Instruction& in) {
      for (uint32_t i = 0; i < in.arguments.size(); ++i)
        if (accessOf(shader_, in, i) != 'r') written(in.arguments[i]);
    });
  }
  struct Mark {
    size_t values, expressions;
  };
  Mark mark() const { return {undo_.size(), forget_.size()}; }
  void rollBack(Mark to) {
    forget(to.expressions);
    while (undo_.size() > to.values) {
      value_[size_t(undo_.back().first)] = undo_.back().second;
      undo_.pop_back();
    }
  }
  SymbolId lookUp(SymbolId s) const {
    const Value& same = value_[size_t(s)].same;
    return holds(same) ? same.is : s;
  }
  const Symbol& symbol(SymbolId s) const { return shader_.symbols[size_t(s)]; }

  bool isFlat(SymbolId s) const {
    return symbol(s).kind == SymbolKind::Constant || !isFloat(symbol(s).type.base) || value_[size_t(s)].isFlat;
  }
  SymbolId slopesOf(SymbolId s) const {
    const Value& slopes = value_[size_t(s)].slopes;
    return holds(slopes) ? slopes.is : s;
  }
  // What is known of the derivatives of what was just written. filterwidth(x - floor(x)) then asks x, and the
  // difference needs none.
  void learnSlopes(const Instruction& in) {
    const uint32_t flags = factsOf(in.opcode).flags;
    if (flags & (kOpBlocks | kOpEffect | kOpTable | kOpTakesDerivs | kOpGlobalState) || in.arguments.size() < 2)
      return;
    const SymbolId to = in.arguments[0];
    if (!isFloat(symbol(to).type.base) || symbol(to).type.arrayLength) return;
    bool allFlat = true;
    for (uint32_t i = 0; i < in.arguments.size(); ++i) {
      if (accessOf(shader_, in, i) != (i == 0 ? 'w' : 'r') || (i > 0 && in.arguments[i] == to)) return;
      allFlat &= i == 0 || isFlat(in.arguments[i]);
    }
    Known known = value_[size_t(to)];
    if (flags & kOpDropsDerivs || allFlat) {
      known.isFlat = true;
      return set(to, known);
    }
    if (in.opcode != Opcode::Add && in.opcode != Opcode::Sub) return;
    const SymbolId a = in.arguments[1], b = in.arguments[2];
    const SymbolId from = isFlat(b) ? a : in.opcode == Opcode::Add && isFlat(a) ? b : kNone;
    if (from == kNone || componentsOf(symbol(from).type.base) != componentsOf(symbol(to).type.base)) return;
    known.slopes = now(slopesOf(from));
    set(to, known);
  }

  bool truth(SymbolId s, bool& answer) const {
    const Symbol& c = symbol(s);
    if (c.kind != SymbolKind::Constant) return false;
    if (!c.values.ints.empty())
      answer = c.values.ints[0] != 0;
    else if (!c.values.floats.empty())
      answer = c.values.floats[0] != 0;
    else if (!c.values.strings.empty())
      answer = !c.values.strings[0].empty();
    else
      return false;
    return true;
  }

  void block(Block& code) {
    std::vector<Instruction> made;
    made.reserve(code.code.size());
    for (Instruction& in : code.code) {
      if (!instruction(in, made)) continue;
      made.push_back(std::move(in));
    }
    code.code = std::move(made);
  }

  // false: the instruction is gone (what replaces it stands in `made` already)
  bool instruction(Instruction& in, std::vector<Instruction>& made) {
    if (in.opcode == Opcode::If) {
      replace(in.arguments[0]);
      bool holds = false;
      if (truth(in.arguments[0], holds)) {
        changed_ = true;
        if (holds || in.blocks.size() > 1) {
          Block taken = std::move(in.blocks[holds ? 0 : 1]);
          block(taken);
          std::move(taken.code.begin(), taken.code.end(), std::back_inserter(made));
        }
        return false;
      }
      for (Block& b : in.blocks) {
        const Mark here = mark();
        block(b);
        rollBack(here);
      }
      for (const Block& b : in.blocks) killWrites(b);
      return true;
    }
    if (isLoop(in.opcode)) {
      block(in.blocks[0]);
      for (size_t k = 1; k < 4; ++k) killWrites(in.blocks[k]);
      const Mark here = mark();
      if (in.opcode != Opcode::DoWhile) block(in.blocks[1]);
      const SymbolId condition = lookUp(in.arguments[0]);
      bool holds = true;
      const bool never = in.opcode != Opcode::DoWhile && truth(condition, holds) && !holds;
      const Mark inside = mark();
      block(in.blocks[2]);
      // `continue` reaches the step from anywhere in the body
      rollBack(inside);
      killWrites(in.blocks[2]);
      block(in.blocks[3]);
      if (in.opcode == Opcode::DoWhile) block(in.blocks[1]);
      replace(in.arguments[0]);
      rollBack(here);
      for (size_t k = 1; k < 4; ++k) killWrites(in.blocks[k]);
      if (never) {
        changed_ = true;
        std::move(in.blocks[0].code.begin(), in.blocks[0].code.end(), std::back_inserter(made));
        std::move(in.blocks[1].code.begin(), in.blocks[1].code.end(), std::back_inserter(made));
        return false;
      }
      return true;
    }
    if (in.opcode == Opcode::Call) {
      const Mark here = mark();
      block(in.blocks[0]);
      rollBack(here);  // it was not opened, so that it may be left anywhere
      killWrites(in.blocks[0]);
      return true;
    }
    if (isJump(in.opcode)) return true;
    for (uint32_t i = 0; i < in.arguments.size(); ++i)
      if (accessOf(shader_, in, i) == 'r') replace(in.arguments[i]);
    if (in.opcode == Opcode::FilterWidth) {
      const SymbolId asked = slopesOf(in.arguments[1]);
      changed_ |= asked != in.arguments[1];
      in.arguments[1] = asked;
    }
    simplify(in);
    if (in.opcode == Opcode::Assign && in.arguments[0] == in.arguments[1]) {
      changed_ = true;
      return false;
    }
    SymbolId folded = kNone;
    if (in.opcode != Opcode::Assign && in.opcode != Opcode::ArrayCopy) {
      folded = folder_.fold(in);
      grow();
      if (folded != kNone) {
        changed_ = true;
        const Type to = symbol(in.arguments[0]).type;
        in.opcode = to.arrayLength ? Opcode::ArrayCopy : Opcode::Assign;
        in.arguments = {in.arguments[0], folded};
      }
    }
    const std::string expression = expressionOf(in);
    if (!expression.empty()) {
      const auto found = computed_.find(expression);
      if (found != computed_.end() && holds(found->second) && found->second.is != in.arguments[0]) {
        in.opcode = symbol(in.arguments[0]).type.arrayLength ? Opcode::ArrayCopy : Opcode::Assign;
        in.arguments = {in.arguments[0], found->second.is};
        changed_ = true;
      }
    }
    for (uint32_t i = 0; i < in.arguments.size(); ++i)
      if (accessOf(shader_, in, i) != 'r') written(in.arguments[i]);
    if (!expression.empty() && in.opcode != Opcode::Assign && in.opcode != Opcode::ArrayCopy) {
      bool own = false;  // an operand that the result overwrote is another value now
      for (size_t i = 1; i < in.arguments.size(); ++i) own |= in.arguments[i] == in.arguments[0];
      if (!own) remember(expression, now(in.arguments[0]));
    }
    if (in.opcode == Opcode::Assign || in.opcode == Opcode::ArrayCopy) {
      SymbolId from = in.arguments[1];
      const SymbolId to = in.arguments[0];
      if (symbol(from).kind == SymbolKind::Constant && !(symbol(from).type == symbol(to).type)) {
        const SymbolId converted = folder_.convert(from, symbol(to).type);
        grow();
        if (converted != kNone) in.arguments[1] = from = converted;
      }
      const Base a = symbol(from).type.base, b = symbol(to).type.base;
      if ((a == b || (isTriple(a) && isTriple(b))) && symbol(from).type.arrayLength == symbol(to).type.arrayLength) {
        Known known;
        known.same = now(from);
        set(to, known);
      }
    }
    learnSlopes(in);
    return true;
  }

  // What an operation computes, of values as they stand here; "" for those that are more than a value.
  std::string expressionOf(const Instruction& in) const {
    if (in.opcode == Opcode::Assign || in.opcode == Opcode::ArrayCopy || in.opcode == Opcode::IsConstant ||
        in.arguments.size() < 2)
      return {};
    if (factsOf(in.opcode).flags & (kOpBlocks | kOpEffect | kOpGlobalState)) return {};
    if (in.opcode == Opcode::ArrayRef || in.opcode == Opcode::GetTextureInfo) return {};
    for (uint32_t i = 0; i < in.arguments.size(); ++i)
      if (accessOf(shader_, in, i) != (i == 0 ? 'w' : 'r')) return {};
    std::string key(1, char(in.opcode));
    const auto add = [&](uint32_t w) { key.append(reinterpret_cast<const char*>(&w), 4); };
    add(uint32_t(symbol(in.arguments[0]).type.base));
    for (size_t i = 1; i < in.arguments.size(); ++i) {
      add(uint32_t(in.arguments[i]));
      add(version_[size_t(in.arguments[i])]);
    }
    return key;
  }
  void remember(const std::string& expression, Value value) {
    Value& slot = computed_[expression];
    forget_.emplace_back(expression, slot);
    slot = value;
  }
  void forget(size_t to) {
    while (forget_.size() > to) {
      computed_[forget_.back().first] = forget_.back().second;
      forget_.pop_back();
    }
  }

  void replace(SymbolId& s) {
    const SymbolId by = lookUp(s);
    if (by == s) return;
    s = by;
    changed_ = true;
  }

  // Identities that keep the bits for every value, NaN and zeros included.
  void simplify(Instruction& in) {
    if (in.arguments.size() != 3) return;
    const Type result = symbol(in.arguments[0]).type;
    const auto isAll = [&](SymbolId s, float value) {
      const Symbol& c = symbol(s);
      if (c.kind != SymbolKind::Constant || c.type.arrayLength || c.type.base == Base::Matrix ||
          c.type.base == Base::String)
        return false;
      if (c.type.base == Base::Int) return float(c.values.ints[0]) == value;
      return std::all_of(c.values.floats.begin(), c.values.floats.end(),
                         [&](float f) { return f == value && !std::signbit(f); });
    };
    const auto become = [&](SymbolId from) {
      const Base base = symbol(from).type.base;
      if (base != result.base && !(isTriple(base) && isTriple(result.base))) return;
      in.opcode = Opcode::Assign;
      in.arguments = {in.arguments[0], from};
      changed_ = true;
    };
    const SymbolId a = in.arguments[1], b = in.arguments[2];
    if (in.opcode == Opcode::Mul && isAll(b, 1)) return become(a);
    if (in.opcode == Opcode::Mul && isAll(a, 1)) return become(b);
    if (in.opcode == Opcode::Div && isAll(b, 1) && result.base == Base::Int) return become(a);
    if (in.opcode == Opcode::Sub && isAll(b, 0)) return become(a);
    if (in.opcode == Opcode::Pow && result.base == Base::Float && symbol(b).kind == SymbolKind::Constant &&
        symbol(b).type.base == Base::Float) {
      const float y = symbol(b).values.floats[0];
      const Opcode other = y == 0.5f      ? Opcode::Sqrt
                           : y == -0.5f   ? Opcode::InverseSqrt
                           : y == 1.f / 3 ? Opcode::Cbrt
                                          : Opcode::Pow;
      if (other != Opcode::Pow) {  // the reference rewrites these, so it is what the language gives
        in.opcode = other;
        in.arguments = {in.arguments[0], a};
        changed_ = true;
      }
    }
  }

  FlatProgram& flat_;
  Shader& shader_;
  ConstantPool pool_;
  Folder folder_;
  std::vector<Known> value_;
  std::vector<uint32_t> version_, writes_;
  std::vector<std::pair<SymbolId, Known>> undo_;
  std::unordered_map<std::string, Value> computed_;  // by expression
  std::vector<std::pair<std::string, Value>> forget_;
  bool changed_ = false;
};

// ---- what nothing reads ----
bool hasEffect(const Instruction& in) {
  if (in.opcode == Opcode::MakeClosure) return false;
  if (factsOf(in.opcode).flags & kOpEffect) return true;
  return in.arguments.empty();
}
bool isEmpty(const Block& block) { return block.code.empty(); }

// The indices of a store into part of a variable that may lie outside, each with how many elements there are: a store
// that nothing reads is not worth keeping, but an index outside is told all the same.
struct DoubtfulIndex {
  SymbolId index;
  int32_t elements;
};
std::vector<DoubtfulIndex> doubtfulIndices(const Shader& shader, const Instruction& in) {
  std::vector<DoubtfulIndex> found;
  const auto look = [&](size_t argument, int32_t elements) {
    const Symbol& index = shader.symbols[size_t(in.arguments[argument])];
    if (index.kind != SymbolKind::Constant || index.values.ints[0] < 0 || index.values.ints[0] >= elements)
      found.push_back({in.arguments[argument], elements});
  };
  switch (in.opcode) {
    case Opcode::ArrayAssign:
      if (const Type& type = shader.symbols[size_t(in.arguments[0])].type; type.base != Base::Closure)
        look(1, type.arrayLength);
      break;
    case Opcode::ComponentAssign:
      look(1, 3);
      break;
    case Opcode::MatrixAssign:
      look(1, 4);
      look(2, 4);
      break;
    case Opcode::CheckIndex:
      look(0, shader.symbols[size_t(in.arguments[1])].values.ints[0]);
      break;
    default:
      break;
  }
  return found;
}

bool removeDead(FlatProgram& flat) {
  Shader& shader = flat.code;
  std::optional<ConstantPool> pool;  // seldom needed
  std::unordered_map<const Instruction*, bool> isDead;
  Liveness liveness(shader);
  liveness.isDead = [&](const Instruction& in, const SymbolSet& after) {
    bool needed = in.opcode == Opcode::CheckIndex ? !doubtfulIndices(shader, in).empty() : hasEffect(in);
    for (uint32_t i = 0; i < in.arguments.size() && !needed; ++i)
      if (accessOf(shader, in, i) != 'r') needed = after.has(in.arguments[i]);
    isDead[&in] = !needed;
    // what computes its indices stays, and this time what it would have stored
    return !needed && (in.opcode == Opcode::CheckIndex || doubtfulIndices(shader, in).empty());
  };
  SymbolSet live(shader.symbols.size());
  for (const Output& o : flat.outputs) live.add(o.symbol);
  liveness.run(shader.main, live);
  bool changed = false;
  const std::function<void(Block&)> sweep = [&](Block& block) {
    std::vector<Instruction> kept;
    kept.reserve(block.code.size());
    for (Instruction& in : block.code) {
      for (Block& inner : in.blocks) sweep(inner);
      bool gone = false;
      if (in.opcode == Opcode::Nop || in.opcode == Opcode::UseParam)
        gone = true;
      else if (in.opcode == Opcode::If || in.opcode == Opcode::Call)
        gone = std::all_of(in.blocks.begin(), in.blocks.end(), isEmpty);
      else if (isLoop(in.opcode) || isJump(in.opcode))
        gone = false;
      else {
        const auto found = isDead.find(&in);
        gone = found != isDead.end() && found->second;
      }
      changed |= gone;
      if (!gone) {
        kept.push_back(std::move(in));
        continue;
      }
      for (const DoubtfulIndex& doubt : doubtfulIndices(shader, in)) {
        if (!pool) pool.emplace(shader);
        Instruction& check = kept.emplace_back();
        check.opcode = Opcode::CheckIndex;
        check.arguments = {doubt.index, pool->ofInt(doubt.elements)};
        check.pos = in.pos;
        check.layer = in.layer;
        check.name = in.name;
      }
    }
    block.code = std::move(kept);
  };
  sweep(shader.main);
  return changed;
}

}  // namespace

void optimise(FlatProgram& flat) {
  open(flat.code.main);
  for (int round = 0; round < 4; ++round) {
    const bool moved = Propagation(flat).run();
    open(flat.code.main);
    pickInstead(flat.code, flat.code.main);
    renameValues(flat);
    const bool removed = removeDead(flat);
    if (!moved && !removed) break;
  }
}

}  // namespace kinora::language

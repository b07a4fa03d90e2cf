// Whether a shader is what everybody behind the reader and the front end takes for granted.
#include <algorithm>

#include "language/front/builtins.h"
#include "language/program/program.h"

namespace kinora::language {

namespace {

constexpr int kMostNested = 500;

// Triples are one kind to the machine.
Base kindOf(Base b) { return isTriple(b) ? Base::Color : b; }
bool isScalar(const Type& t) { return t.arrayLength == 0 && (t.base == Base::Int || t.base == Base::Float); }
bool isTripleValue(const Type& t) { return t.arrayLength == 0 && isTriple(t.base); }
bool is(const Type& t, Base b) { return t.arrayLength == 0 && kindOf(t.base) == kindOf(b); }

class Validator {
 public:
  explicit Validator(const Shader& s) : s_(s) {}

  std::string run() {
    structures();
    symbols();
    if (!why_.empty()) return why_;
    for (const Initialiser& i : s_.initialisers) {
      const auto* p = symbol(i.parameter);
      if (!p || (p->kind != SymbolKind::Param && p->kind != SymbolKind::OutputParam))
        return "code initialises what is no parameter";
      block(i.code, 0, 0);
    }
    block(s_.main, 0, 0);
    return why_;
  }

 private:
  void wrong(const std::string& what) {
    if (why_.empty()) why_ = what;
  }
  const Symbol* symbol(SymbolId id) const {
    return id >= 0 && size_t(id) < s_.symbols.size() ? &s_.symbols[size_t(id)] : nullptr;
  }

  bool goodType(const Type& t) const {
    if (t.base > Base::Struct || t.arrayLength < -1 || t.arrayLength > kMostElements) return false;
    return t.base == Base::Struct ? t.structure >= 0 && size_t(t.structure) < s_.structures.size() : true;
  }
  void structures() {
    for (size_t i = 0; i < s_.structures.size(); ++i) {
      size_t leaves = 0;
      for (const Field& f : s_.structures[i].fields) {
        if (!goodType(f.type) || f.type.base == Base::Void || f.type.arrayLength < 0)
          return wrong("a field of struct " + s_.structures[i].name + " has no sensible type");
        // of one declared before: no struct holds itself
        if (f.type.base == Base::Struct && size_t(f.type.structure) >= i)
          return wrong("struct " + s_.structures[i].name + " holds itself");
        leaves += f.type.base == Base::Struct ? sizes_[size_t(f.type.structure)] : 1;
        if (leaves > 10000) return wrong("struct " + s_.structures[i].name + " is too large");
      }
      sizes_.push_back(leaves + 1);
    }
  }
  static bool goodValues(const Type& t, const Values& v, bool mayBeEmpty) {
    const size_t n = t.base == Base::Int      ? v.ints.size()
                     : t.base == Base::String ? v.strings.size()
                                              : v.floats.size();
    const size_t all = v.ints.size() + v.floats.size() + v.strings.size();
    if (all != n) return false;
    const auto components = size_t(componentsOf(t.base));
    if (components == 0) return n == 0;
    if (n == 0 && mayBeEmpty) return true;
    if (t.arrayLength < 0) return n % components == 0;
    return n == components * size_t(t.arrayLength == 0 ? 1 : t.arrayLength);
  }
  void symbols() {
    if (!why_.empty()) return;
    for (size_t i = 0; i < s_.symbols.size() && why_.empty(); ++i) {
      const Symbol& s = s_.symbols[i];
      const bool isParameter = s.kind == SymbolKind::Param || s.kind == SymbolKind::OutputParam;
      if (s.kind > SymbolKind::Constant || !goodType(s.type) || s.type.base == Base::Void)
        return wrong("symbol " + s.name + " has no sensible type");
      if (s.type.arrayLength < 0 && !isParameter) return wrong("symbol " + s.name + " has no length");
      if (!goodValues(s.type, s.values, s.kind != SymbolKind::Constant))
        return wrong("symbol " + s.name + " has the wrong number of values");
      if (s.kind == SymbolKind::Constant && componentsOf(s.type.base) == 0)
        return wrong("constant " + s.name + " has no value");
      for (const Metadata& m : s.metadata)
        if (!goodType(m.type) || !goodValues(m.type, m.values, true))
          return wrong("metadata " + m.name + " of " + s.name + " makes no sense");
      if (s.type.base == Base::Struct) fields(i);
      if (s.ofStruct != kNone && !symbol(s.ofStruct)) return wrong("symbol " + s.name + " is a field of nothing");
    }
  }
  // Returns the symbol behind the last field.
  size_t fields(size_t at) {
    const Symbol& s = s_.symbols[at];
    size_t next = at + 1;
    const Structure& structure = s_.structures[size_t(s.type.structure)];
    for (size_t f = 0; f < structure.fields.size(); ++f) {
      const auto* field = symbol(SymbolId(next));
      Type t = structure.fields[f].type;
      if (s.type.arrayLength != 0) {
        if (t.arrayLength != 0) return wrong("struct " + s.name + " is an array of arrays"), next;
        t.arrayLength = s.type.arrayLength;
      }
      if (!field || field->type != t || field->ofStruct != SymbolId(at) || field->field != int32_t(f) ||
          field->kind != s.kind)
        return wrong("the fields of " + s.name + " do not follow it"), next;
      next = t.base == Base::Struct ? fields(next) : next + 1;
      if (!why_.empty()) return next;
    }
    return next;
  }

  void block(const Block& b, int depth, int loops) {
    if (depth > kMostNested) return wrong("code is nested too deeply");
    for (const Instruction& i : b.code) {
      if (!why_.empty()) return;
      instruction(i, depth, loops);
    }
  }

  void instruction(const Instruction& i, int depth, int loops) {
    const OpcodeFacts& facts = factsOf(i.opcode);
    if (i.opcode >= Opcode::Count) return wrong("an unknown opcode");
    const auto fail = [&](const std::string& what) {
      wrong((i.pos.line ? i.pos.str() + ": " : std::string()) + std::string(facts.name) + " " + what);
    };
    size_t least = facts.letters.size();
    const bool hasRest = facts.letters.ends_with('*');
    if (hasRest) least -= 2;
    if (i.arguments.size() < least || (!hasRest && i.arguments.size() > least))
      return fail("has the wrong number of operands");
    types_.clear();
    for (size_t a = 0; a < i.arguments.size(); ++a) {
      const auto* s = symbol(i.arguments[a]);
      if (!s) return fail("has an operand that does not exist");
      types_.push_back(s->type);
    }
    for (size_t a = 0; a < i.arguments.size(); ++a) {
      const Symbol& s = *symbol(i.arguments[a]);
      if (s.kind == SymbolKind::Constant && accessOf(s_, i, uint32_t(a)) != 'r')
        return fail("writes the constant " + s.name);
    }
    if ((i.opcode == Opcode::Break || i.opcode == Opcode::Continue) && loops == 0)
      return fail("stands outside of a loop");
    const bool isLoop = i.opcode == Opcode::For || i.opcode == Opcode::While || i.opcode == Opcode::DoWhile;
    const size_t blocks = isLoop ? 4 : i.opcode == Opcode::If ? 2 : i.opcode == Opcode::Call ? 1 : 0;
    if (i.blocks.size() != blocks) return fail("has the wrong number of blocks");
    if (!goodOperands(i)) return fail("cannot take these operands: " + operandText());
    for (const Block& b : i.blocks) block(b, depth + 1, isLoop ? loops + 1 : i.opcode == Opcode::Call ? 0 : loops);
  }

  std::string operandText() const {
    std::string s;
    for (const Type& t : types_) s += (s.empty() ? "" : ", ") + nameOf(t);
    return s;
  }

  bool arithmetic(Opcode op) const {
    const Type &r = types_[0], &a = types_[1], &b = types_[2];
    if (r.arrayLength || a.arrayLength || b.arrayLength) return false;
    if (r.base == Base::Closure) {
      if (op == Opcode::Add) return a.base == Base::Closure && b.base == Base::Closure;
      const bool isFirst = a.base == Base::Closure;
      const Type& weight = isFirst ? b : a;
      return op == Opcode::Mul && (isFirst || b.base == Base::Closure) && (isScalar(weight) || isTripleValue(weight));
    }
    if (r.base == Base::Int) return a.base == Base::Int && b.base == Base::Int;
    if (r.base == Base::Float) return isScalar(a) && isScalar(b);
    if (isTriple(r.base)) return (isTripleValue(a) || isScalar(a)) && (isTripleValue(b) || isScalar(b));
    const auto fits = [](const Type& t) { return t.base == Base::Matrix || isScalar(t); };
    return r.base == Base::Matrix && (op == Opcode::Mul || op == Opcode::Div) && fits(a) && fits(b);
  }
  bool comparison(Opcode op) const {
    const Type &r = types_[0], &a = types_[1], &b = types_[2];
    if (!is(r, Base::Int) || a.arrayLength || b.arrayLength) return false;
    if (isScalar(a) && isScalar(b)) return true;
    if (op != Opcode::Eq && op != Opcode::Neq) return false;
    if (a.base == Base::String || b.base == Base::String) return a.base == b.base;
    const auto isClosure = [](const Type& t) { return t.base == Base::Closure || t.base == Base::Int; };
    if (a.base == Base::Closure || b.base == Base::Closure) return isClosure(a) && isClosure(b);  // none or not
    const auto isNumber = [](const Type& t) { return isScalar(t) || isTripleValue(t) || t.base == Base::Matrix; };
    if (!isNumber(a) || !isNumber(b)) return false;
    return kindOf(a.base) == kindOf(b.base) || isScalar(a) || isScalar(b);
  }

  // Those that control flow and the core of the language use; the library's are in the front end's table.
  bool goodOperands(const Instruction& i) const {
    const auto& t = types_;
    const auto all = [&](Base b, size_t from) {
      return std::all_of(t.begin() + long(from), t.end(), [&](const Type& x) { return is(x, b); });
    };
    switch (i.opcode) {
      case Opcode::Nop:
      case Opcode::End:
      case Opcode::Break:
      case Opcode::Continue:
      case Opcode::Return:
      case Opcode::Exit:
      case Opcode::UseParam:
        return true;
      case Opcode::If:
      case Opcode::For:
      case Opcode::While:
      case Opcode::DoWhile:
        return is(t[0], Base::Int);
      case Opcode::Call:
        return is(t[0], Base::String);
      case Opcode::Assign: {
        if (t[0].arrayLength || t[1].arrayLength || t[0].base == Base::Struct) return false;
        if (t[0].base == Base::Closure) return t[1].base == Base::Closure || t[1].base == Base::Int;
        return front::assignable(t[0], t[1]) || (t[0].base == Base::Int && t[1].base == Base::Float);
      }
      case Opcode::ArrayCopy:
        return t[0].arrayLength && t[1].arrayLength && t[0].base != Base::Struct &&
               kindOf(t[0].base) == kindOf(t[1].base) &&
               (t[0].arrayLength < 0 || t[1].arrayLength < 0 || t[0].arrayLength >= t[1].arrayLength);
      case Opcode::ArrayRef:
        return t[1].arrayLength && t[1].base != Base::Struct && is(t[0], t[1].base) && is(t[2], Base::Int);
      case Opcode::ArrayAssign:
        return t[0].arrayLength && t[0].base != Base::Struct && is(t[1], Base::Int) &&
               (is(t[2], t[0].base) || (t[0].base == Base::Closure && is(t[2], Base::Int)));
      case Opcode::ComponentRef:
        return is(t[0], Base::Float) && isTripleValue(t[1]) && is(t[2], Base::Int);
      case Opcode::ComponentAssign:
        return isTripleValue(t[0]) && is(t[1], Base::Int) && isScalar(t[2]);
      case Opcode::MatrixRef:
        return is(t[0], Base::Float) && is(t[1], Base::Matrix) && all(Base::Int, 2);
      case Opcode::MatrixAssign:
        return is(t[0], Base::Matrix) && is(t[1], Base::Int) && is(t[2], Base::Int) && isScalar(t[3]);
      case Opcode::ArrayLength:
        return is(t[0], Base::Int) && t[1].arrayLength;
      case Opcode::Add:
      case Opcode::Sub:
      case Opcode::Mul:
      case Opcode::Div:
        return arithmetic(i.opcode);
      case Opcode::Neg:
        return t[0].arrayLength == 0 && is(t[1], t[0].base) &&
               (isScalar(t[0]) || isTriple(t[0].base) || t[0].base == Base::Matrix);
      case Opcode::Mod:
      case Opcode::BitAnd:
      case Opcode::BitOr:
      case Opcode::BitXor:
      case Opcode::ShiftLeft:
      case Opcode::ShiftRight:
      case Opcode::Complement:
      case Opcode::And:
      case Opcode::Or:
        return all(Base::Int, 0);
      case Opcode::Eq:
      case Opcode::Neq:
      case Opcode::Lt:
      case Opcode::Le:
      case Opcode::Gt:
      case Opcode::Ge:
        return comparison(i.opcode);
      case Opcode::MakeColor:
      case Opcode::MakePoint:
      case Opcode::MakeVector:
      case Opcode::MakeNormal: {
        if (!isTripleValue(t[0]) || (t.size() != 4 && t.size() != 5)) return false;
        return all(Base::Float, t.size() - 3) && (t.size() == 4 || is(t[1], Base::String));
      }
      case Opcode::MakeMatrix: {
        if (t.size() < 2 || !is(t[0], Base::Matrix)) return false;
        if (t.size() == 3 && is(t[1], Base::String) && is(t[2], Base::String)) return true;
        const size_t first = is(t[1], Base::String) ? 2 : 1;
        return (t.size() == first + 1 || t.size() == first + 16) && all(Base::Float, first);
      }
      case Opcode::MakeClosure:
        return t.size() >= 2 && is(t[0], Base::Closure) && is(t[1], Base::String) &&
               symbol(i.arguments[1])->kind == SymbolKind::Constant;
      default:
        return library(i.opcode);
    }
  }

  bool matches(const front::Formal& f, const Type& t) const {
    if (f.isAny) return t.base != Base::Struct;
    if ((f.type.arrayLength != 0) != (t.arrayLength != 0)) return false;
    return kindOf(f.type.base) == kindOf(t.base);
  }
  bool library(Opcode op) const {
    std::string_view name = factsOf(op).name;
    if (op == Opcode::FloorMod) name = "mod";
    if (op == Opcode::TransformVector || op == Opcode::TransformNormal) name = "transform";
    const front::Builtin* b = front::builtinNamed(name);
    if (!b) return false;
    for (const front::Signature& s : front::signaturesOf(*b)) {
      const size_t first = s.result.base == Base::Void ? 0 : 1;
      if (first && (types_.empty() || !matches({s.result, false, false}, types_[0]))) continue;
      const size_t n = types_.size() - first;
      if (n < s.count || (s.rest == 0 && n > s.count)) continue;
      bool isGood = s.rest != '@' || (n - s.count) % 2 == 0;
      for (size_t a = 0; isGood && a < n; ++a) {
        if (s.rest == '@' && a >= s.count && (a - s.count) % 2 == 0)
          isGood = is(types_[first + a], Base::String);
        else
          isGood = matches(s.at(uint32_t(a)), types_[first + a]);
      }
      if (isGood) return true;
    }
    return false;
  }

  const Shader& s_;
  std::vector<size_t> sizes_;
  std::vector<Type> types_;
  std::string why_;
};

}  // namespace

std::string invalid(const Shader& shader) { return Validator(shader).run(); }

}  // namespace kinora::language

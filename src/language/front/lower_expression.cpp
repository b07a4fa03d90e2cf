// Expressions, but for calls. `want` is where the caller will put the value: an operation whose result has that type
// writes it there at once; whoever asks compares the answer with what it wanted.
#include <algorithm>

#include "language/front/constants.h"
#include "language/front/lower.h"

namespace kinora::language::front {

namespace {

Opcode opcodeOf(Punct op) {
  switch (op) {
    case Punct::Plus:
      return Opcode::Add;
    case Punct::Minus:
      return Opcode::Sub;
    case Punct::Star:
      return Opcode::Mul;
    case Punct::Slash:
      return Opcode::Div;
    case Punct::Percent:
      return Opcode::Mod;
    case Punct::And:
      return Opcode::BitAnd;
    case Punct::Or:
      return Opcode::BitOr;
    case Punct::Xor:
      return Opcode::BitXor;
    case Punct::ShiftLeft:
      return Opcode::ShiftLeft;
    case Punct::ShiftRight:
      return Opcode::ShiftRight;
    case Punct::AndAnd:
      return Opcode::And;
    case Punct::OrOr:
      return Opcode::Or;
    case Punct::Equal:
      return Opcode::Eq;
    case Punct::NotEqual:
      return Opcode::Neq;
    case Punct::Less:
      return Opcode::Lt;
    case Punct::LessEq:
      return Opcode::Le;
    case Punct::Greater:
      return Opcode::Gt;
    case Punct::GreaterEq:
      return Opcode::Ge;
    default:
      return Opcode::Nop;
  }
}

bool alike(const Type& a, const Type& b) {
  return a == b || (isPlain(a) && isPlain(b) && isTriple(a.base) && isTriple(b.base));
}

// Evaluating it changes nothing, cannot go wrong and costs little: && and || need no branch for it.
bool isCheap(const Expr& e, int depth) {
  if (depth == 0 || e.function) return false;
  switch (e.kind) {
    case ExprKind::Int:
    case ExprKind::Float:
    case ExprKind::String:
    case ExprKind::Variable:
      return true;
    case ExprKind::Field:
      return isCheap(*e.a, depth - 1);
    case ExprKind::Unary:
      return isCheap(*e.a, depth - 1);
    case ExprKind::Binary:
      return isPlain(e.type) && componentsOf(e.type.base) == 1 && isCheap(*e.a, depth - 1) &&
             isCheap(*e.b, depth - 1);
    default:
      return false;
  }
}

}  // namespace

SymbolId Lowerer::result(const Type& type, SymbolId want, Pos pos) {
  return want != kNone && alike(typeOf(want), type) ? want : temporary(type, pos);
}

// The value as one of type `to`; itself where the machine makes no difference.
SymbolId Lowerer::converted(SymbolId v, const Type& to, Pos pos) {
  const Type from = typeOf(v);
  if (alike(from, to) || from.base == to.base || to.base == Base::Void || to.base == Base::Struct) return v;
  if (isPlain(from) && out_.symbols[size_t(v)].kind == SymbolKind::Constant && to.base != Base::Closure &&
      !isTriple(from.base))
    return constant(to, front::converted(out_.symbols[size_t(v)].values, from, to));
  const SymbolId t = temporary(to, pos);
  emit(Opcode::Assign, {t, v}, pos);
  return t;
}

void Lowerer::assign(SymbolId to, SymbolId from, Pos pos) {
  if (to == from) return;
  const Type type = typeOf(to);
  if (type.base == Base::Struct) {
    for (size_t i = 1, n = sizeOf(type); i < n; ++i)
      if (typeOf(to + SymbolId(i)).base != Base::Struct) assign(to + SymbolId(i), from + SymbolId(i), pos);
    return;
  }
  if (isPlain(type) && out_.symbols[size_t(from)].kind == SymbolKind::Constant && type.base != Base::Closure)
    from = converted(from, type, pos);  // a literal 1 for a float is 1.0
  emit(type.arrayLength != 0 ? Opcode::ArrayCopy : Opcode::Assign, {to, from}, pos);
}

Lowerer::Place Lowerer::place(Expr* e) {
  const Deeper deeper(*this, e->pos);
  Place p;
  switch (e->kind) {
    case ExprKind::Variable:
      p.symbol = symbolOf(e->var);
      break;
    case ExprKind::Field:
      p = place(e->a);
      if (e->a->type.base == Base::Struct)
        p.symbol = fieldOf(p.symbol, e->field);
      else
        p.component = constant(e->field);
      break;
    case ExprKind::Index:
      p = place(e->a);
      if (e->c) {
        p.component = value(e->b);
        p.column = value(e->c);
      } else if (e->a->type.arrayLength != 0) {
        p.element = value(e->b);
      } else {
        p.component = value(e->b);
      }
      break;
    default:
      p.symbol = value(e);
  }
  p.type = e->type;
  return p;
}

SymbolId Lowerer::load(const Place& p, Pos pos) {
  if (p.isWhole()) return p.symbol;
  SymbolId v = p.symbol;
  if (p.element != kNone) {
    const Type array = typeOf(v);
    const SymbolId t = temporary({array.base, 0, array.structure}, pos);
    for (size_t i = 0, n = sizeOf(array); i < n; ++i)
      if (typeOf(t + SymbolId(i)).base != Base::Struct)
        emit(Opcode::ArrayRef, {t + SymbolId(i), v + SymbolId(i), p.element}, pos);
    v = t;
  }
  if (p.component == kNone) return v;
  const SymbolId t = temporary({Base::Float, 0, -1}, pos);
  if (p.column != kNone)
    emit(Opcode::MatrixRef, {t, v, p.component, p.column}, pos);
  else
    emit(Opcode::ComponentRef, {t, v, p.component}, pos);
  return t;
}

void Lowerer::storeElement(SymbolId array, SymbolId element, SymbolId v, Pos pos) {
  const Type type = typeOf(array);
  if (type.base != Base::Struct) {
    emit(Opcode::ArrayAssign, {array, element, converted(v, {type.base, 0, -1}, pos)}, pos);
    return;
  }
  for (size_t i = 1, n = sizeOf(type); i < n; ++i)
    if (typeOf(array + SymbolId(i)).base != Base::Struct)
      emit(Opcode::ArrayAssign, {array + SymbolId(i), element, v + SymbolId(i)}, pos);
}

void Lowerer::store(const Place& p, SymbolId v, Pos pos) {
  if (p.isWhole()) return assign(p.symbol, v, pos);
  if (p.component == kNone) return storeElement(p.symbol, p.element, v, pos);
  SymbolId whole = p.symbol;
  if (p.element != kNone) whole = load({p.symbol, p.type, p.element, kNone, kNone}, pos);
  v = converted(v, {Base::Float, 0, -1}, pos);
  if (p.column != kNone)
    emit(Opcode::MatrixAssign, {whole, p.component, p.column, v}, pos);
  else
    emit(Opcode::ComponentAssign, {whole, p.component, v}, pos);
  if (p.element != kNone) storeElement(p.symbol, p.element, whole, pos);
}

SymbolId Lowerer::value(Expr* e, SymbolId want) {
  const Deeper deeper(*this, e->pos);
  switch (e->kind) {
    case ExprKind::Int:
      return constant(e->intValue);
    case ExprKind::Float:
      return constant(e->floatValue);
    case ExprKind::String:
      return constant(e->text);
    case ExprKind::Variable:
      return symbolOf(e->var);
    case ExprKind::Index:
    case ExprKind::Field:
      return load(place(e), e->pos);
    case ExprKind::Assign:
      return assignment(e);
    case ExprKind::Increment:
      return increment(e, true);
    case ExprKind::Ternary:
      return ternary(e, want);
    case ExprKind::Call:
      return call(e, want);
    case ExprKind::List:
      return list(e, kNone);
    case ExprKind::Construct:
      return construct(e, e->type.base, want);
    case ExprKind::Cast: {
      if (e->a->kind == ExprKind::List) return value(e->a, want);
      return converted(value(e->a, want), e->type, e->pos);
    }
    case ExprKind::Comma:
      for (size_t i = 0; i + 1 < e->list.size(); ++i) effects(e->list[i]);
      return value(e->list.back(), want);
    case ExprKind::Unary: {
      Values literal;
      if (!e->function && constantOf(*e, literal)) return constant(e->type, std::move(literal));
      if (e->function) {
        Expr* operand[] = {e->a};
        return inlined(e->function, operand, {}, e->pos);
      }
      if (e->op == Punct::Plus) return value(e->a, want);
      if (e->op == Punct::Not) {
        const SymbolId v = condition(e->a);
        const SymbolId t = result(e->type, want, e->pos);
        emit(Opcode::Eq, {t, v, constant(0)}, e->pos);
        return t;
      }
      const SymbolId v = value(e->a);
      const SymbolId t = result(e->type, want, e->pos);
      emit(e->op == Punct::Tilde ? Opcode::Complement : Opcode::Neg, {t, v}, e->pos);
      return t;
    }
    case ExprKind::Binary: {
      Values literal;
      if (constantOf(*e, literal)) return constant(e->type, std::move(literal));
      if (e->function) {
        Expr* operands[] = {e->a, e->b};
        return inlined(e->function, operands, {}, e->pos);
      }
      if (e->op == Punct::AndAnd || e->op == Punct::OrOr) return logical(e);
      const SymbolId a = value(e->a), b = value(e->b);
      return binary(e, a, b, want);
    }
    case ExprKind::Bad:
      break;
  }
  return constant(0);
}

void Lowerer::effects(Expr* e) {
  if (e->kind == ExprKind::Increment)
    increment(e, false);
  else
    value(e);
}

// As an int that is 0 or not.
SymbolId Lowerer::condition(Expr* e) { return truth(value(e), e->pos); }

SymbolId Lowerer::truth(SymbolId v, Pos pos) {
  const Base b = typeOf(v).base;
  if (b == Base::Int) return v;
  const SymbolId t = temporary({Base::Int, 0, -1}, pos);
  const SymbolId none = b == Base::String    ? constant(std::string_view())
                        : b == Base::Closure ? constant(0)
                                             : constant(0.f);
  emit(Opcode::Neq, {t, v, none}, pos);
  return t;
}

SymbolId Lowerer::binary(Expr* e, SymbolId a, SymbolId b, SymbolId want) {
  const Base ba = typeOf(a).base, bb = typeOf(b).base;
  constexpr Type kFloat{Base::Float, 0, -1};
  if (!(ba == Base::Int && bb == Base::Int)) {
    if (ba == Base::Int) a = converted(a, kFloat, e->pos);
    if (bb == Base::Int) b = converted(b, kFloat, e->pos);
  }
  if (bb == Base::Closure && ba != Base::Closure) std::swap(a, b);  // the weight stands behind
  const SymbolId t = result(e->type, want, e->pos);
  emit(opcodeOf(e->op), {t, a, b}, e->pos);
  return t;
}

SymbolId Lowerer::logical(Expr* e) {
  const bool isAnd = e->op == Punct::AndAnd;
  const SymbolId a = condition(e->a);
  const SymbolId t = temporary({Base::Int, 0, -1}, e->pos);
  if (isCheap(*e->b, 4)) {
    const SymbolId b = condition(e->b);
    emit(isAnd ? Opcode::And : Opcode::Or, {t, a, b}, e->pos);
    return t;
  }
  emit(Opcode::Neq, {t, a, constant(0)}, e->pos);
  Block right = block(e->pos, [&] {
    const SymbolId b = condition(e->b);
    emit(Opcode::Neq, {t, b, constant(0)}, e->pos);
  });
  Instruction& i = emit(Opcode::If, {t}, e->pos);
  i.blocks.resize(2);
  i.blocks[isAnd ? 0 : 1] = std::move(right);
  return t;
}

SymbolId Lowerer::ternary(Expr* e, SymbolId want) {
  const SymbolId test = condition(e->a);
  const SymbolId t = e->type.base == Base::Struct || e->type.arrayLength != 0 ? temporary(e->type, e->pos)
                                                                              : result(e->type, want, e->pos);
  const auto side = [&](Expr* x) {
    return block(x->pos, [&] { assign(t, value(x, e->type.base == Base::Struct ? kNone : t), x->pos); });
  };
  Block then = side(e->b), other = side(e->c);
  Instruction& i = emit(Opcode::If, {test}, e->pos);
  i.blocks.reserve(2);
  i.blocks.push_back(std::move(then));
  i.blocks.push_back(std::move(other));
  return t;
}

SymbolId Lowerer::assignment(Expr* e) {
  const Place p = place(e->a);
  SymbolId v;
  if (e->op == Punct::Assign) {
    v = value(e->b, p.isWhole() && p.type.base != Base::Struct ? p.symbol : kNone);
  } else {
    const SymbolId before = load(p, e->pos);
    const SymbolId b = e->b->kind == ExprKind::List ? list(e->b, kNone) : value(e->b);
    if (e->c->function) {
      Expr* operands[] = {e->a, e->b};
      const SymbolId values[] = {before, b};
      v = inlined(e->c->function, operands, values, e->pos);
    } else {
      v = binary(e->c, before, b, p.isWhole() ? p.symbol : kNone);
    }
  }
  store(p, v, e->pos);
  return p.isWhole() ? p.symbol : converted(v, e->type, e->pos);
}

SymbolId Lowerer::increment(Expr* e, bool isUsed) {
  const Place p = place(e->a);
  const SymbolId one = e->type.base == Base::Int ? constant(1) : constant(1.f);
  SymbolId before = load(p, e->pos);
  if (isUsed && !e->isPrefix && p.isWhole()) {
    const SymbolId copy = temporary(e->type, e->pos);
    emit(Opcode::Assign, {copy, before}, e->pos);
    before = copy;
  }
  const SymbolId after = p.isWhole() ? p.symbol : temporary(e->type, e->pos);
  emit(e->op == Punct::Increment ? Opcode::Add : Opcode::Sub, {after, before, one}, e->pos);
  if (!p.isWhole()) store(p, after, e->pos);
  return e->isPrefix ? after : before;
}

// Of e.list, for constructors and lists that are one.
SymbolId Lowerer::construct(Expr* e, Base base, SymbolId want) {
  Values literal;
  if (constantOf(*e, literal)) return constant(e->type, std::move(literal));
  if (e->list.size() == 1) {
    const Type from = e->list[0]->type;
    const SymbolId v = value(e->list[0], want != kNone && alike(from, typeOf(want)) ? want : kNone);
    if (alike(typeOf(v), e->type)) return v;
    if (isPlain(typeOf(v)) && out_.symbols[size_t(v)].kind == SymbolKind::Constant)
      return converted(v, e->type, e->pos);
    const SymbolId t = result(e->type, want, e->pos);
    emit(Opcode::Assign, {t, v}, e->pos);
    return t;
  }
  std::vector<SymbolId> arguments = {kNone};
  for (size_t i = 0; i < e->list.size(); ++i) {
    const SymbolId v = value(e->list[i]);
    arguments.push_back(typeOf(v).base == Base::String ? v : converted(v, {Base::Float, 0, -1}, e->pos));
  }
  arguments[0] = result(e->type, want, e->pos);
  const Opcode op = base == Base::Color    ? Opcode::MakeColor
                    : base == Base::Point  ? Opcode::MakePoint
                    : base == Base::Vector ? Opcode::MakeVector
                    : base == Base::Normal ? Opcode::MakeNormal
                                           : Opcode::MakeMatrix;
  const SymbolId t = arguments[0];
  emit(op, std::move(arguments), e->pos);
  return t;
}

// `want`: a variable nobody has read, or none.
SymbolId Lowerer::list(Expr* e, SymbolId want) {
  const Deeper deeper(*this, e->pos);
  const Type& type = e->type;
  if (type.arrayLength == 0 && type.base != Base::Struct) {
    if (type.base == Base::String || type.base == Base::Closure) return value(e->list[0]);
    return construct(e, type.base, want);
  }
  Values literal;
  if (type.base != Base::Struct && constantOf(*e, literal)) return constant(type, std::move(literal));
  const SymbolId into = want != kNone && typeOf(want) == type ? want : temporary(type, e->pos);
  fillList(e, into);
  return into;
}

void Lowerer::fillList(Expr* e, SymbolId into) {
  const Type type = typeOf(into);
  for (size_t i = 0; i < e->list.size(); ++i) {
    Expr* x = e->list[i];
    if (type.arrayLength != 0) {
      storeElement(into, constant(int32_t(i)), x->kind == ExprKind::List ? list(x, kNone) : value(x), x->pos);
      continue;
    }
    const SymbolId field = fieldOf(into, int32_t(i));
    assign(field, x->kind == ExprKind::List ? list(x, field) : value(x), x->pos);
  }
  if (type.arrayLength == 0) {
    // what the list leaves out is zero
    const SymbolId end = into + SymbolId(sizeOf(type));
    for (SymbolId s = fieldOf(into, int32_t(e->list.size())); s < end; ++s) {
      const Type t = typeOf(s);
      if (t.base == Base::Struct) continue;
      const SymbolId zero = t.base == Base::Closure ? constant(0) : constant(t, zeros(t));
      if (t.base != Base::Closure || t.arrayLength == 0)
        emit(t.arrayLength ? Opcode::ArrayCopy : Opcode::Assign, {s, zero}, e->pos);
    }
    return;
  }
  if (type.base == Base::Struct || int32_t(e->list.size()) >= type.arrayLength) return;
  Values zero = zeros({type.base, 0, -1});
  const SymbolId rest = type.base == Base::Closure ? constant(0) : constant({type.base, 0, -1}, std::move(zero));
  // what the list leaves out is zero
  if (type.arrayLength - int32_t(e->list.size()) > 256)
    messages_.fatal(e->pos, "the list leaves out too many elements");
  for (auto i = int32_t(e->list.size()); i < type.arrayLength; ++i)
    emit(Opcode::ArrayAssign, {into, constant(i), rest}, e->pos);
}

}  // namespace kinora::language::front

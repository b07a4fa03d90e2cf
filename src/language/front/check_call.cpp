// Calls: which of the functions of a name is meant (reference: osl-numerics, section 11), what it may be given.
#include <algorithm>

#include "base/near_name.h"
#include "language/front/checker.h"
#include "language/front/constants.h"

namespace kinora::language::front {

namespace {

constexpr Type kFloat{Base::Float, 0, -1};

// preferred first, when nothing else decides
int rankOf(Base b) {
  static constexpr Base kOrder[] = {Base::Float,   Base::Int,    Base::Color,  Base::Vector,
                                    Base::Point,   Base::Normal, Base::Matrix, Base::String,
                                    Base::Closure, Base::Struct, Base::Void};
  return int(std::find(std::begin(kOrder), std::end(kOrder), b) - std::begin(kOrder));
}

std::string_view operatorName(Punct op, bool isUnary) {
  switch (op) {
    case Punct::Plus:
      return "__operator__add__";
    case Punct::Minus:
      return isUnary ? "__operator__neg__" : "__operator__sub__";
    case Punct::Star:
      return "__operator__mul__";
    case Punct::Slash:
      return "__operator__div__";
    case Punct::Percent:
      return "__operator__mod__";
    case Punct::Not:
      return "__operator__not__";
    case Punct::Tilde:
      return "__operator__compl__";
    case Punct::Equal:
      return "__operator__eq__";
    case Punct::NotEqual:
      return "__operator__ne__";
    case Punct::Less:
      return "__operator__lt__";
    case Punct::LessEq:
      return "__operator__le__";
    case Punct::Greater:
      return "__operator__gt__";
    case Punct::GreaterEq:
      return "__operator__ge__";
    case Punct::And:
      return "__operator__bitand__";
    case Punct::Or:
      return "__operator__bitor__";
    case Punct::Xor:
      return "__operator__xor__";
    case Punct::ShiftLeft:
      return "__operator__shl__";
    case Punct::ShiftRight:
      return "__operator__shr__";
    default:
      return "";
  }
}

}  // namespace

bool Checker::fits(Expr* list, const Type& type) const {
  const auto elementFits = [&](Expr* x, const Type& t) {
    return x->kind == ExprKind::List ? fits(x, t)
                                     : x->kind == ExprKind::Call || isPoison(x->type) || assignable(t, x->type);
  };
  if (type.arrayLength != 0) {
    if (type.arrayLength > 0 && list->list.size() > size_t(type.arrayLength)) return false;
    return std::all_of(list->list.begin(), list->list.end(), [&](Expr* x) {
      return elementFits(x, {type.base, 0, type.structure});
    });
  }
  if (type.base == Base::Struct) {
    const auto& fields = structures_[size_t(type.structure)].fields;
    if (fields.size() != list->list.size()) return false;
    for (size_t i = 0; i < fields.size(); ++i)
      if (!elementFits(list->list[i], fields[i].type)) return false;
    return true;
  }
  if (isTriple(type.base)) {
    const bool hasSpace = list->list.size() == 4 && list->list[0]->type.base == Base::String;
    return list->list.size() == 3 || list->list.size() == 1 || hasSpace;
  }
  if (type.base == Base::Matrix) return list->list.size() == 16 || list->list.size() == 1;
  return list->list.size() == 1;
}

int Checker::scoreOf(const Type& formal, Expr* argument) {
  if (argument->kind == ExprKind::List) return fits(argument, formal) ? 100 : 0;
  return matchScore(formal, argument->type);
}

// Fills the scores; false when the candidate cannot be called so.
bool Checker::match(Candidate& c, std::span<Expr*> arguments, Type expected) {
  int score = 0;
  Type result;
  if (c.function) {
    const Function& f = *c.function;
    if (f.isClosure ? arguments.size() < f.parameters.size() : arguments.size() != f.parameters.size()) return false;
    for (size_t i = 0; i < f.parameters.size(); ++i) {
      if (isPoison(f.parameters[i]->type)) {
        score += 100;
        continue;
      }
      const int s = scoreOf(f.parameters[i]->type, arguments[i]);
      if (s == 0) return false;
      score += s;
    }
    result = f.type;
  } else {
    const Signature& s = *c.signature;
    if (arguments.size() < s.count || (s.rest == 0 && arguments.size() > s.count)) return false;
    if (s.rest == '@' && arguments.size() > s.count) {
      const Expr* token = arguments[s.count];
      if (token->kind == ExprKind::List || token->type != Type{Base::String, 0, -1}) return false;
    }
    for (uint32_t i = 0; i < arguments.size(); ++i) {
      const Formal f = s.at(i);
      if (arguments[i]->kind == ExprKind::List && f.isAny) return false;
      const bool hasType = f.isAny ? arguments[i]->type != Type{} : true;
      const int one = f.isAny ? (hasType ? 1 : 0) : scoreOf(f.type, arguments[i]);
      if (one == 0) return false;
      if (i < s.count || s.rest == '+') score += one;
    }
    result = s.result;
  }
  c.score = score;
  c.resultScore = expected.base == Base::Void ? 0 : matchScore(expected, result);
  return true;
}

std::string Checker::signatureText(const Candidate& c) const {
  std::string s;
  if (c.function) {
    for (const Var* p : c.function->parameters)
      s += (s.empty() ? "" : ", ") + std::string(p->isOutput ? "output " : "") + text(p->type);
    return text(c.function->type) + " " + text(c.function->name) + " (" + s + ")";
  }
  for (uint32_t i = 0; i < c.signature->count; ++i) {
    const Formal& f = c.signature->formals[i];
    s += (s.empty() ? "" : ", ") + std::string(f.isOutput ? "output " : "") + (f.isAny ? "any" : text(f.type));
  }
  if (c.signature->rest != 0) s += s.empty() ? "..." : ", ...";
  return text(c.signature->result) + " " + std::string(c.builtin->name) + " (" + s + ")";
}

Function* Checker::operatorFor(Expr* e, std::span<Expr*> operands, Type expected) {
  const Name name = names_.find(operatorName(e->op, operands.size() == 1));
  if (name == 0 || isInPrelude_) return nullptr;
  const bool isStruct =
      std::any_of(operands.begin(), operands.end(), [](const Expr* x) { return x->type.base == Base::Struct; });
  Candidate best;
  for (Function* f = functions_[name]; f; f = f->next) {
    Candidate c;
    c.function = f->definition ? f->definition : f;
    if (!match(c, operands, expected)) continue;
    // the language's own operators stay as they are where they fit
    if (!isStruct && c.score < 100 * int(operands.size())) continue;
    if (c.score > best.score) best = c;
  }
  if (!best.function) return nullptr;
  e->function = best.function;
  if (std::find(checking_.begin(), checking_.end(), best.function) != checking_.end())
    error(e->pos, "function '" + text(name) + "' calls itself; recursion is not possible");
  bind(e, best, operands);
  return best.function;
}

// A variable that is declared nearer than every function of its name hides them all.
bool Checker::isHiddenByVariable(Name name) {
  if (isInPrelude_) return false;
  const VarEntry& entry = vars_[name];
  const Function* f = functions_[name];
  return entry.var && !isPoison(entry.var->type) && entry.scope > (f ? f->scope : 0);
}

Type Checker::structConstruct(Expr* e, int32_t structure) {
  e->isStructConstruct = true;
  return list(e, {Base::Struct, 0, structure});
}

// Of a list that is an argument: its type is known when the function is, and nothing is checked twice.
bool Checker::checkElements(Expr* list) {
  bool isGood = true;
  for (Expr* x : list->list) {
    if (x->kind == ExprKind::List) {
      isGood &= checkElements(x);
      continue;
    }
    isGood &= !isPoison(check(x));
    x->isChecked = true;
  }
  return isGood;
}

Type Checker::call(Expr* e, Type expected) {
  if (const int32_t s = isInPrelude_ ? 0 : structs_[e->name]; s != 0) return structConstruct(e, s - 1);
  if (isHiddenByVariable(e->name)) {
    for (Expr* x : e->list)
      if (x->kind != ExprKind::List) check(x);
    error(e->pos, "'" + text(e->name) + "' is a variable and cannot be called");
    return kPoison;
  }
  bool isGood = true;
  for (Expr* x : e->list) {
    if (x->kind == ExprKind::List) {
      x->type = kPoison;
      isGood &= checkElements(x);
    } else {
      isGood &= !isPoison(check(x, expected));
    }
  }
  const std::string_view name = names_.text(e->name);
  loadPrelude(e->name);
  std::vector<Candidate> candidates;
  if (!isInPrelude_)
    for (Function* f = functions_[e->name]; f; f = f->next) {
      if (f->definition) continue;
      candidates.push_back({});
      candidates.back().function = f;
    }
  for (Function* f = prelude_[e->name]; f; f = f->next) {
    candidates.push_back({});
    candidates.back().function = f;
  }
  if (const Builtin* b = builtinNamed(name)) {
    Candidate c;
    c.builtin = b;
    for (const Signature& s : signaturesOf(*b)) {
      c.signature = &s;
      candidates.push_back(c);
    }
  }
  if (candidates.empty()) {
    if (!isGood) return kPoison;
    std::vector<std::string> near;
    for (size_t i = 1; i < std::min<size_t>(names_.size(), functions_.of.size()); ++i)
      if (functions_.of[i]) near.push_back(text(Name(i)));
    for (const char* n : {"noise", "texture", "normalize", "smoothstep", "clamp", "transform", "length", "dot",
                          "cross", "luminance", "getattribute"})
      near.push_back(n);
    const std::string hint = didYouMean(std::string(name), near);
    error(e->pos, "there is no function '" + std::string(name) + "'" + (hint.empty() ? "" : "; " + hint));
    return kPoison;
  }
  if (!isGood) return kPoison;
  std::vector<Candidate> fitting;
  const auto findFitting = [&] {
    for (Candidate& c : candidates)
      if (match(c, e->list, expected)) fitting.push_back(c);
  };
  findFitting();
  // vector(rotate(p, noise("perlin", P), a, b)): what the call is to give says nothing of its angle
  if (fitting.empty() && expected.base != Base::Void && !(expected == kFloat)) {
    for (Expr* x : e->list)
      if (x->kind != ExprKind::List) check(x, kFloat);
    findFitting();
  }
  if (fitting.empty()) {
    std::string given;
    for (const Expr* x : e->list)
      given += (given.empty() ? "" : ", ") + (x->kind == ExprKind::List ? "{...}" : text(x->type));
    std::string known;
    for (size_t i = 0; i < candidates.size() && i < 4; ++i) known += (i ? "; " : "") + signatureText(candidates[i]);
    if (candidates.size() > 4) known += "; and " + std::to_string(candidates.size() - 4) + " more";
    error(e->pos, "no function '" + std::string(name) + "' takes (" + given + "); there is " + known);
    return kPoison;
  }
  const auto typeOf = [](const Candidate& c) { return c.function ? c.function->type : c.signature->result; };
  size_t best = 0, ties = 1;
  const auto sameFormals = [&](const Candidate& a, const Candidate& b) {
    for (size_t i = 0; i < e->list.size(); ++i) {
      const auto formal = [&](const Candidate& c) {
        return c.function ? (i < c.function->parameters.size() ? c.function->parameters[i]->type : Type{})
                          : c.signature->at(uint32_t(i)).type;
      };
      if (formal(a) != formal(b)) return false;
    }
    return true;
  };
  for (size_t i = 1; i < fitting.size(); ++i) {
    const Candidate &c = fitting[i], &b = fitting[best];
    if (c.score > b.score || (c.score == b.score && c.resultScore > b.resultScore)) {
      best = i;
      ties = 1;
    } else if (c.score == b.score && c.resultScore == b.resultScore) {
      if (typeOf(c) == typeOf(b) && sameFormals(c, b)) continue;  // what is declared nearest hides the others
      ++ties;
      if (rankOf(typeOf(c).base) < rankOf(typeOf(b).base)) best = i;
    }
  }
  // what a function hides is what its own body means by the name
  const auto isActive = [&](const Candidate& c) {
    return c.function && std::find(checking_.begin(), checking_.end(), c.function) != checking_.end();
  };
  for (size_t i = 0; i < fitting.size() && isActive(fitting[best]); ++i)
    if (!isActive(fitting[i]) && sameFormals(fitting[i], fitting[best])) best = i;
  const Candidate chosen = fitting[best];
  if (ties > 1) {
    std::string given, known;
    for (const Expr* x : e->list)
      given += (given.empty() ? "" : ", ") + (x->kind == ExprKind::List ? "{...}" : text(x->type));
    size_t shown = 0, structs = 0;
    bool hasList = false;
    for (const Expr* x : e->list) hasList |= x->kind == ExprKind::List;
    for (const Candidate& c : fitting) {
      if (c.score != chosen.score || c.resultScore != chosen.resultScore) continue;
      structs += typeOf(c).base == Base::Struct;
      if (++shown <= 5) known += (known.empty() ? "" : "; ") + signatureText(c);
    }
    const std::string what = "ambiguous call to '" + std::string(name) + " (" + given + ")'; ";
    if (structs > 1 || hasList) {
      error(e->pos, what + "it may be " + known);
      return kPoison;
    }
    messages_.warning(e->pos, what + "taken is " + signatureText(chosen) + "; it may be " + known);
  }
  bind(e, chosen, e->list);
  if (isActive(chosen)) {
    error(e->pos, "function '" + std::string(name) + "' calls itself; recursion is not possible");
    return kPoison;
  }
  if (uses_ && (chosen.builtin || chosen.function->isPrelude)) use(signatureText(chosen));
  special(e);
  return typeOf(chosen);
}

// Outputs can be written to, lists get their types.
void Checker::bind(Expr* e, const Candidate& c, std::span<Expr*> arguments) {
  e->function = c.function;
  e->builtin = c.builtin;
  e->signature = c.signature;
  for (uint32_t i = 0; i < arguments.size(); ++i) {
    Formal f;
    if (c.builtin) {
      f = c.signature->at(i);
    } else if (i < c.function->parameters.size()) {
      f.type = c.function->parameters[i]->type;
      f.isOutput = c.function->parameters[i]->isOutput;
    } else {
      f.isAny = true;
    }
    Expr* x = arguments[i];
    if (x->kind == ExprKind::List) {
      x->type = list(x, f.type);
      continue;
    }
    if (!f.isOutput) continue;
    const bool fitsBack = f.isAny || isPoison(f.type) || f.type.base == x->type.base ||
                          (isTriple(f.type.base) && isTriple(x->type.base));
    if (!fitsBack)
      error(x->pos, "the output of type '" + text(f.type) + "' does not fit into '" + text(x->type) + "'");
    else
      writable(x);
  }
}

void Checker::special(Expr* e) {
  if (!e->builtin) return;
  const auto list = e->list;
  const auto isParameter = [](const Expr* x) {
    for (; x->kind == ExprKind::Field; x = x->a) {
    }
    return x->kind == ExprKind::Variable && x->var &&
           (x->var->kind == VarKind::Parameter || x->var->kind == VarKind::OutputParameter ||
            x->var->kind == VarKind::Argument || x->var->kind == VarKind::OutputArgument);
  };
  switch (e->builtin->opcode) {
    case Opcode::Printf:
    case Opcode::Error:
    case Opcode::Warning:
    case Opcode::Format:
      format(e, 0);
      break;
    case Opcode::Fprintf:
      format(e, 1);
      break;
    case Opcode::IsConnected:
      if (!isParameter(list[0])) error(list[0]->pos, "isconnected() asks about a parameter of the shader");
      break;
    case Opcode::ArrayLength:
      if (list[0]->type.arrayLength == 0)
        error(list[0]->pos, "arraylength() takes an array, not '" + text(list[0]->type) + "'");
      break;
    case Opcode::SetMessage:
    case Opcode::GetMessage:
    case Opcode::GetAttribute:
    case Opcode::GetTextureInfo:
    case Opcode::DictValue:
    case Opcode::IsConstant:
      if (list.back()->type.base == Base::Struct)
        error(list.back()->pos, std::string(e->builtin->name) + "() takes no struct");
      else if (list.back()->type.base == Base::Closure && e->builtin->opcode != Opcode::SetMessage &&
               e->builtin->opcode != Opcode::GetMessage)
        error(list.back()->pos, std::string(e->builtin->name) + "() takes no closure");
      break;
    default:
      break;
  }
  // tokens and values
  const Signature& s = *e->signature;
  if (s.rest != '@') return;
  for (size_t i = s.count; i < list.size(); i += 2) {
    if (list[i]->type != Type{Base::String, 0, -1})
      return error(list[i]->pos,
                   "expected the name of an option, found a value of type '" + text(list[i]->type) + "'");
    if (i + 1 == list.size()) return error(list[i]->pos, "this option has no value");
    if (list[i + 1]->type.base == Base::Struct) return error(list[i + 1]->pos, "a struct is no value of an option");
    if (list[i]->kind == ExprKind::String && e->builtin->opcode != Opcode::MakeClosure &&
        (list[i]->text == "alpha" || list[i]->text == "errormessage"))
      writable(list[i + 1]);
  }
}

// reference: osl-numerics, section 9
void Checker::format(Expr* e, size_t at) {
  const Expr* f = e->list[at];
  if (f->kind != ExprKind::String) {
    messages_.warning(f->pos, "the format is not constant: it is not checked");
    return;
  }
  size_t next = at + 1;
  const std::string_view s = f->text;
  for (size_t i = 0; i < s.size(); ++i) {
    if (s[i] != '%') continue;
    if (i + 1 < s.size() && s[i + 1] == '%') {
      ++i;
      continue;
    }
    const size_t end = s.find_first_of("cdefgimnopsuvxX", i + 1);
    if (end == std::string_view::npos) return error(f->pos, "the format ends inside of a conversion");
    if (next >= e->list.size()) return error(f->pos, "the format has more conversions than there are values");
    const Expr* x = e->list[next++];
    const Base b = x->type.base;
    const char c = s[end];
    const std::string_view allowed = b == Base::String || b == Base::Closure ? "s"
                                     : b == Base::Int                        ? "dioxX"
                                     : b == Base::Struct || b == Base::Void  ? ""
                                                                             : "fgecmnpv";
    if (allowed.empty()) return error(x->pos, "a value of type '" + text(x->type) + "' cannot be printed");
    if (allowed.find(c) == std::string_view::npos)
      return error(x->pos, "conversion %" + std::string(1, c) + " does not fit '" + text(x->type) + "'; use %" +
                               std::string(1, allowed[0]));
    i = end;
  }
  if (next < e->list.size()) error(e->list[next]->pos, "the format has fewer conversions than there are values");
}

}  // namespace kinora::language::front

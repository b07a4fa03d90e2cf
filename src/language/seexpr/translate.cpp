#include "language/seexpr/translate.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

#include "language/seexpr/functions.h"
#include "language/seexpr/syntax.h"

namespace kinora::language::seexpr {

namespace {

// Each operation of an expression becomes a statement; more of them are refused.
constexpr uint32_t kMostStatements = 8000;
constexpr size_t kMostKnots = 256;
constexpr uint32_t kLongestChain = 600;  // a + b + c ... nests to the left, without brackets
constexpr uint32_t kMostCalls = 150;     // one in the argument of another: they take most of the stack

enum class Type : uint8_t { Number, Vector, String };

struct Value {
  Type type = Type::Number;
  std::string text;  // a variable or a literal of the shading language; of a string its characters
};

struct Given {
  Type type;
  std::string_view code;  // assigns to X
};
// What the renderer knows of a point. Vectors and positions in world space, as shaders see them.
const std::map<std::string_view, Given>& givenVariables() {
  static const std::map<std::string_view, Given> kGiven = {
      {"P", {Type::Vector, "X = (vector)P;"}},
      {"Pobj", {Type::Vector, "X = (vector)transform(\"object\", P);"}},
      {"Po", {Type::Vector, "X = (vector)transform(\"object\", P);"}},
      {"N", {Type::Vector, "X = (vector)normalize(N);"}},
      {"Nn", {Type::Vector, "X = (vector)normalize(N);"}},
      {"Ng", {Type::Vector, "X = (vector)normalize(Ng);"}},
      {"Ngn", {Type::Vector, "X = (vector)normalize(Ng);"}},
      {"Vn", {Type::Vector, "X = -normalize(I);"}},
      {"VLen", {Type::Number, "X = length((vector)transform(\"camera\", P));"}},
      {"Tn", {Type::Vector, "getattribute(\"builtin\", \"Tn\", X);"}},
      {"Cs", {Type::Vector, "color cs = 1; getattribute(\"Cs\", cs); X = (vector)cs;"}},
      {"s", {Type::Number, "getattribute(\"s\", X);"}},
      {"t", {Type::Number, "getattribute(\"t\", X);"}},
      {"u", {Type::Number, "getattribute(\"builtin\", \"u\", X);"}},
      {"v", {Type::Number, "getattribute(\"builtin\", \"v\", X);"}},
      {"w", {Type::Number, "X = 0.0;"}},
      {"objectId", {Type::Number, "getattribute(\"builtin\", \"id\", X);"}},
      {"time", {Type::Number, "X = time;"}},
      {"PI", {Type::Number, "X = M_PI;"}},
      {"E", {Type::Number, "X = M_E;"}},
  };
  return kGiven;
}

std::string literal(double x) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", x);
  std::string s = text;
  if (s.find_first_of(".e") == std::string::npos) s += ".0";
  return s;
}

class Translator {
 public:
  Translator(const Tree& tree, const std::vector<Input>& inputs) : tree_(tree), inputs_(inputs) {}

  Translation run(const std::string& shaderName) {
    statements(tree_.statements);
    const Value result = value(tree_.result);
    if (result.type == Type::String) fail(tree_.nodes[tree_.result], "the result is a string");
    Translation t;
    t.inputs.assign(used_.begin(), used_.end());
    t.source = std::string(librarySource()) + "shader " + shaderName + "(";
    for (const Input& input : inputs_)
      if (used_.count(input.name))
        t.source += std::string(input.isTriple ? "color " : "float ") + parameterOf(input.name) + " = 0, ";
    t.source +=
        "output color resultRGB = 0, output float resultR = 0, output float resultG = 0, output float resultB = 0, "
        "output float resultF = 0) {\n" +
        declarations_ + code_;
    const bool triple = result.type == Type::Vector;
    line(t.source, "vector the_result = " + (triple ? result.text : "vector(" + result.text + ")"));
    line(t.source, "resultRGB = (color)the_result");
    line(t.source, "resultR = the_result[0]");
    line(t.source, "resultG = the_result[1]");
    line(t.source, "resultB = the_result[2]");
    line(t.source, "resultF = the_result[0]");
    t.source += "}\n";
    return t;
  }

 private:
  [[noreturn]] void fail(const Node& n, std::string what) const { throw Refused{n.place, std::move(what)}; }
  static void line(std::string& to, const std::string& statement) { to += "  " + statement + ";\n"; }
  static const char* keywordOf(Type t) { return t == Type::Vector ? "vector" : "float"; }

  // A new variable with the value of an expression of the shading language.
  Value emit(Type type, const std::string& expression) {
    const Value v = declare(type);
    line(code_, v.text + " = " + expression);
    return v;
  }
  void count() {
    if (++count_ > kMostStatements)
      throw Refused{place_, "it needs more than " + std::to_string(kMostStatements) + " operations"};
  }
  Value declare(Type type) {
    count();
    const Value v{type, "x" + std::to_string(count_)};
    line(declarations_, std::string(keywordOf(type)) + " " + v.text + " = 0.0");
    return v;
  }
  std::string asVector(const Value& v) const { return v.type == Type::Vector ? v.text : "vector(" + v.text + ")"; }
  std::string as(Type type, const Value& v) const { return type == Type::Vector ? asVector(v) : v.text; }
  // Conditions look at the first component.
  std::string first(const Value& v) const { return v.type == Type::Vector ? v.text + "[0]" : v.text; }
  static Type widest(Type a, Type b) { return a == Type::Vector || b == Type::Vector ? Type::Vector : Type::Number; }
  static std::string part(const Value& v, int k) {
    return v.type == Type::Vector ? v.text + "[" + std::to_string(k) + "]" : v.text;
  }

  void statements(const std::vector<uint32_t>& list) {
    for (const uint32_t i : list) {
      const Node& n = tree_.nodes[i];
      if (n.kind == Node::Kind::If) {
        condition(n);
        continue;
      }
      const Value v = numeric(n.children[0]);
      const auto it = variables_.find(n.text);
      if (it != variables_.end() && it->second.type == v.type && owned_.count(it->second.text)) {
        place_ = n.place;
        count();
        line(code_, it->second.text + " = " + v.text);
      } else {
        variables_[n.text] = emit(v.type, v.text);
        owned_.insert(variables_[n.text].text);
      }
    }
  }
  // Variables that both ways have remain, as vectors where one way makes them vectors.
  void condition(const Node& n) {
    const Value test = numeric(n.children[0]);
    const std::map<std::string, Value> before = variables_;
    std::string outer = std::move(code_);
    std::string code[2];
    std::map<std::string, Value> after[2];
    for (int way = 0; way < 2; ++way) {
      code_.clear();
      variables_ = before;
      statements(way == 0 ? n.body : n.otherwise);
      code[way] = std::move(code_);
      after[way] = std::move(variables_);
    }
    variables_.clear();
    for (const auto& [name, yes] : after[0]) {
      const auto it = after[1].find(name);
      if (it == after[1].end()) continue;
      const Value& no = it->second;
      if (yes.text == no.text) {
        variables_[name] = yes;
        continue;
      }
      place_ = n.place;
      const Value joined = declare(widest(yes.type, no.type));
      line(code[0], joined.text + " = " + as(joined.type, yes));
      line(code[1], joined.text + " = " + as(joined.type, no));
      owned_.insert(joined.text);
      variables_[name] = joined;
    }
    code_ = std::move(outer) + "  if (" + first(test) + " != 0.0) {\n" + code[0] + "  } else {\n" + code[1] + "  }\n";
  }

  Value numeric(uint32_t i) {
    Value v = value(i);
    if (v.type == Type::String) fail(tree_.nodes[i], "a string stands where a number is expected");
    return v;
  }
  struct Deeper {
    uint32_t& depth;
    ~Deeper() { --depth; }
  };
  Value value(uint32_t i) {
    const Node& n = tree_.nodes[i];
    place_ = n.place;
    const Deeper level{++depth_};
    if (depth_ > kLongestChain) fail(n, "more than " + std::to_string(kLongestChain) + " operations in a row");
    switch (n.kind) {
      case Node::Kind::Number:
        return {Type::Number, literal(n.number)};
      case Node::Kind::String:
        return {Type::String, n.text};
      case Node::Kind::Variable:
        return variable(n);
      case Node::Kind::Vector:
        return vectorOf(n);
      case Node::Kind::Component:
        return component(n);
      case Node::Kind::Unary:
        return unary(n);
      case Node::Kind::Binary:
        return binary(n);
      case Node::Kind::Choice: {
        const Value test = numeric(n.children[0]), yes = numeric(n.children[1]), no = numeric(n.children[2]);
        const Type type = widest(yes.type, no.type);
        return emit(type, first(test) + " != 0.0 ? " + as(type, yes) + " : " + as(type, no));
      }
      case Node::Kind::Call:
        return call(n);
      default:
        fail(n, "a statement stands where a value is expected");
    }
  }
  Value variable(const Node& n) {
    if (const auto it = variables_.find(n.text); it != variables_.end()) {
      // a copy: it may be assigned to before this value is used
      return emit(it->second.type, it->second.text);
    }
    if (const auto it = givenVariables().find(n.text); it != givenVariables().end()) {
      const auto [known, isNew] = given_.try_emplace(n.text);
      if (isNew) {
        known->second = declare(it->second.type);
        std::string code(it->second.code);
        for (size_t at; (at = code.find('X')) != std::string::npos;) code.replace(at, 1, known->second.text);
        // before everything else, whatever way it is met on
        declarations_ += "  { " + code + " }\n";
      }
      return known->second;
    }
    for (const Input& input : inputs_)
      if (input.name == n.text) {
        used_.insert(n.text);
        const std::string name = parameterOf(n.text);
        return input.isTriple ? emit(Type::Vector, "(vector)" + name) : Value{Type::Number, name};
      }
    fail(n, "there is no variable '" + n.text + "'");
  }
  Value vectorOf(const Node& n) {
    if (n.children.size() != 3)
      fail(n, "a vector has three components; this one has " + std::to_string(n.children.size()));
    std::string text;
    for (const uint32_t c : n.children) {
      const Value v = numeric(c);
      if (v.type == Type::Vector) fail(tree_.nodes[c], "a component of a vector is a number, not a vector");
      text += (text.empty() ? "vector(" : ", ") + v.text;
    }
    return emit(Type::Vector, text + ")");
  }
  Value component(const Node& n) {
    const Value v = numeric(n.children[0]);
    const Node& index = tree_.nodes[n.children[1]];
    const Value k = numeric(n.children[1]);
    if (index.kind == Node::Kind::Number && !(index.number >= 0 && index.number < 3))
      fail(index, "a vector has the components 0, 1 and 2");
    if (v.type == Type::Number) return v;
    if (index.kind == Node::Kind::Number) return emit(Type::Number, part(v, int(index.number)));
    return emit(Type::Number, v.text + "[clamp((int)" + first(k) + ", 0, 2)]");
  }
  Value unary(const Node& n) {
    const Value v = numeric(n.children[0]);
    if (n.text == "-") return emit(v.type, "-" + v.text);
    if (n.text == "~") return emit(v.type, as(v.type, {Type::Number, "1.0"}) + " - " + v.text);
    if (v.type == Type::Number) return emit(Type::Number, "(" + v.text + " == 0.0) ? 1.0 : 0.0");
    std::string text = "vector(";
    for (int k = 0; k < 3; ++k) text += std::string(k ? ", " : "") + "(" + part(v, k) + " == 0.0) ? 1.0 : 0.0";
    return emit(Type::Vector, text + ")");
  }
  Value binary(const Node& n) {
    const Value a = numeric(n.children[0]), b = numeric(n.children[1]);
    const std::string& op = n.text;
    const auto truth = [&](const std::string& test) { return emit(Type::Number, "(" + test + ") ? 1.0 : 0.0"); };
    if (op == "&&" || op == "||") return truth(first(a) + " != 0.0 " + op + " " + first(b) + " != 0.0");
    if (op == "<" || op == ">" || op == "<=" || op == ">=") return truth(first(a) + " " + op + " " + first(b));
    const Type type = widest(a.type, b.type);
    const std::string x = as(type, a), y = as(type, b);
    if (op == "==" || op == "!=") return truth(x + " " + op + " " + y);
    // of the sign of the second, as SeExpr has it: patterns repeat alike on both sides of the origin
    if (op == "%") return emit(type, "mod(" + x + ", " + y + ")");
    if (op == "^") return emit(type, "pow(" + x + ", " + y + ")");
    return emit(type, x + " " + op + " " + y);
  }

  // ---- calls ----
  std::vector<Value> arguments(const Node& n, size_t least, size_t most) {
    if (n.children.size() < least || n.children.size() > most) {
      const std::string range = least == most ? std::to_string(least)
                                : most > 999  ? "at least " + std::to_string(least)
                                              : std::to_string(least) + " to " + std::to_string(most);
      fail(n, n.text + "() takes " + range + " arguments and gets " + std::to_string(n.children.size()));
    }
    std::vector<Value> list;
    for (const uint32_t c : n.children) list.push_back(numeric(c));
    return list;
  }
  Value call(const Node& n) {
    const Deeper level{++calls_};
    if (calls_ > kMostCalls) fail(n, "more than " + std::to_string(kMostCalls) + " calls in each other");
    if (const Function* f = findFunction(n.text)) return plainCall(n, *f);
    if (n.text == "noise") return noise(n);
    if (n.text == "hash") return hashed(arguments(n, 1, 16));
    if (n.text == "rand") {
      const std::vector<Value> a = arguments(n, 0, 3);
      const Value h = hashed(a.size() == 3 ? std::vector<Value>{a[2]} : std::vector<Value>{variableNamed("P", n)});
      return a.size() < 2 ? h : emit(Type::Number, "mix(" + first(a[0]) + ", " + first(a[1]) + ", " + h.text + ")");
    }
    if (n.text == "choose" || n.text == "swatch" || n.text == "wchoose" || n.text == "pick") return chosen(n);
    if (n.text == "spline") {
      const std::vector<Value> a = arguments(n, 5, kMostKnots);
      std::string text = "spline(\"catmull-rom\", clamp(" + first(a[0]) + ", 0.0, 1.0)";
      for (size_t i = 1; i < a.size(); ++i) text += ", " + first(a[i]);
      return emit(Type::Number, text + ")");
    }
    if (n.text == "curve" || n.text == "ccurve") return curve(n);
    fail(n, "there is no function '" + n.text + "'");
  }
  Value variableNamed(const char* name, const Node& n) {
    Node v = n;
    v.text = name;
    return variable(v);
  }
  Value plainCall(const Node& n, const Function& f) {
    const size_t most = f.signature.size() - 1;
    std::vector<std::string> defaults;
    for (size_t at = 0; !f.defaults.empty() && at != std::string_view::npos;) {
      const size_t end = f.defaults.find('|', at);
      defaults.push_back(std::string(f.defaults.substr(at, end == std::string_view::npos ? end : end - at)));
      at = end == std::string_view::npos ? end : end + 1;
    }
    std::vector<Value> a = arguments(n, most - defaults.size(), most);
    while (a.size() < most) a.push_back({Type::Number, defaults[a.size() - (most - defaults.size())]});
    Type each = Type::Number;
    for (size_t i = 0; i < most; ++i) {
      const char wanted = f.signature[i + 1];
      if (wanted == 'f' && a[i].type == Type::Vector)
        fail(tree_.nodes[n.children[i]],
             "argument " + std::to_string(i + 1) + " of " + n.text + "() is a number, not a vector");
      if (wanted == 'v') a[i] = {Type::Vector, asVector(a[i])};
      if (wanted == 'e') each = widest(each, a[i].type);
    }
    const Type type = f.signature[0] == 'v' ? Type::Vector : f.signature[0] == 'f' ? Type::Number : each;
    const auto called = [&](int k) {
      std::string text = std::string(f.code) + "(";
      for (size_t i = 0; i < most; ++i) {
        const bool single = k >= 0 && f.signature[i + 1] == 'e';
        text += (i ? ", " : "") + (single ? part(a[i], k) : f.signature[i + 1] == 'e' ? as(each, a[i]) : a[i].text);
      }
      return text + ")";
    };
    if (f.signature[0] == 'e' && each == Type::Vector && !f.isNative)
      return emit(type, "vector(" + called(0) + ", " + called(1) + ", " + called(2) + ")");
    return emit(type, called(-1));
  }
  Value noise(const Node& n) {
    const std::vector<Value> a = arguments(n, 1, 4);
    const auto at = [&](size_t k) { return first(a[k]); };
    switch (a.size()) {
      case 1:
        return emit(Type::Number,
                    a[0].type == Type::Vector ? "se_noise3(" + a[0].text + ")" : "se_noise1(" + a[0].text + ")");
      case 2:
        if (a[0].type == Type::Vector) return emit(Type::Number, "se_noise4(" + a[0].text + ", " + at(1) + ")");
        return emit(Type::Number, "se_noise2(" + at(0) + ", " + at(1) + ")");
      case 3:
        return emit(Type::Number, "se_noise3(vector(" + at(0) + ", " + at(1) + ", " + at(2) + "))");
      default:
        return emit(Type::Number, "se_noise4(vector(" + at(0) + ", " + at(1) + ", " + at(2) + "), " + at(3) + ")");
    }
  }
  // All numbers, one after the other, into one.
  Value hashed(const std::vector<Value>& seeds) {
    std::string h = "0.0";
    for (const Value& s : seeds)
      for (int k = 0; k < (s.type == Type::Vector ? 3 : 1); ++k)
        h = emit(Type::Number, "se_hash(" + part(s, k) + ", " + h + ")").text;
    return {Type::Number, h};
  }
  // An array of the shading language; the name of a new variable.
  std::string array(Type type, const std::vector<std::string>& values) {
    const std::string name = "a" + std::to_string(++count_);
    const std::string n = std::to_string(values.size());
    line(declarations_, std::string(keywordOf(type)) + " " + name + "[" + n + "]");
    for (size_t i = 0; i < values.size(); ++i) line(code_, name + "[" + std::to_string(i) + "] = " + values[i]);
    return name;
  }
  Value chosen(const Node& n) {
    const bool weighted = n.text == "wchoose", picked = n.text == "pick";
    const std::vector<Value> a = arguments(n, picked ? 3 : weighted ? 5 : 2, kMostKnots);
    const std::string x = first(a[0]);
    if (picked) {
      const std::string h = hashed({a[0]}).text, low = "floor(" + first(a[1]) + ")";
      if (a.size() == 3)
        return emit(Type::Number, "min(" + low + " + floor(" + h + " * max(floor(" + first(a[2]) + ") - " + low +
                                      " + 1.0, 1.0)), floor(" + first(a[2]) + "))");
      std::vector<std::string> weights;
      for (size_t i = 3; i < a.size(); ++i) weights.push_back(first(a[i]));
      return emit(Type::Number, low + " + se_weighted(" + h + ", " + array(Type::Number, weights) + ")");
    }
    if (weighted && a.size() % 2 == 0) fail(n, "wchoose() takes an index, and a value and a weight each time");
    Type type = Type::Number;
    std::vector<const Value*> choices;
    std::vector<std::string> texts, weights;
    for (size_t i = 1; i < a.size(); i += weighted ? 2 : 1) {
      choices.push_back(&a[i]);
      type = widest(type, a[i].type);
      if (weighted) weights.push_back(first(a[i + 1]));
    }
    for (const Value* v : choices) texts.push_back(as(type, *v));
    const std::string count = std::to_string(texts.size()), values = array(type, texts);
    const std::string index = weighted ? "se_weighted(" + x + ", " + array(Type::Number, weights) + ")"
                              : n.text == "choose"
                                  ? "clamp((int)floor(" + x + " * " + count + ".0), 0, " + count + " - 1)"
                                  : "clamp((int)floor(" + x + "), 0, " + count + " - 1)";
    return emit(type, values + "[" + index + "]");
  }
  // curve(x, position, value, interpolation, ...)
  Value curve(const Node& n) {
    const bool colors = n.text == "ccurve";
    const std::vector<Value> a = arguments(n, 4, 1 + 3 * kMostKnots);
    if (a.size() % 3 != 1)
      fail(n, n.text + "() takes a parameter, and a position, a value and an interpolation each time");
    // knots that are written as numbers are brought into order; others count as they stand
    std::vector<size_t> order;
    bool written = true;
    for (size_t i = 1; i < a.size(); i += 3) {
      order.push_back(i);
      written = written && tree_.nodes[n.children[i]].kind == Node::Kind::Number;
    }
    if (written)
      std::stable_sort(order.begin(), order.end(), [&](size_t l, size_t r) {
        return tree_.nodes[n.children[l]].number < tree_.nodes[n.children[r]].number;
      });
    std::vector<std::string> positions, kinds;
    for (const size_t i : order) positions.push_back(first(a[i])), kinds.push_back(first(a[i + 2]));
    const std::string pos = array(Type::Number, positions), interp = array(Type::Number, kinds);
    const auto along = [&](int k) {
      std::vector<std::string> values;
      for (const size_t i : order) values.push_back(part(a[i + 1], k));
      return "se_curve(" + first(a[0]) + ", " + pos + ", " + array(Type::Number, values) + ", " + interp + ")";
    };
    if (!colors) return emit(Type::Number, along(0));
    const std::string r = along(0), g = along(1), b = along(2);
    return emit(Type::Vector, "vector(" + r + ", " + g + ", " + b + ")");
  }

  const Tree& tree_;
  const std::vector<Input>& inputs_;
  std::string declarations_, code_;
  uint32_t count_ = 0, depth_ = 0, calls_ = 0;
  Place place_;
  std::map<std::string, Value> variables_, given_;
  std::set<std::string> owned_;  // variables that assignments may write to
  std::set<std::string> used_;
};

}  // namespace

std::string parameterOf(const std::string& input) { return "in_" + input; }

Translation translate(std::string_view expression, const std::vector<Input>& inputs, const std::string& shaderName) {
  Translation t;
  try {
    const Tree tree = parse(expression);
    t = Translator(tree, inputs).run(shaderName);
  } catch (const Refused& r) {
    t.problem = std::to_string(r.place.line) + ":" + std::to_string(r.place.column) + ": " + r.what;
  }
  return t;
}

}  // namespace kinora::language::seexpr

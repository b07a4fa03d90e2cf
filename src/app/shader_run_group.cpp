// The shader group that a command line of `kinora shader run` describes, or a text: statements `param TYPE NAME
// VALUES [[hints]] ;`, `shader NAME LAYER ;` and `connect LAYER.OUTPUT LAYER.INPUT ;`, as other programs write them.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>

#include "app/shader_run.h"
#include "language/program/quoted.h"
#include "language/library/text.h"
#include "language/optimise/instrument.h"

namespace kinora::app {

using language::Base;
using language::Type;
using language::Values;

namespace {

namespace fs = std::filesystem;

constexpr size_t kMostValues = size_t(1) << 20;

bool typeNamed(std::string text, Type& type) {
  type = {};
  if (text.ends_with(']')) {
    const size_t open = text.find('[');
    if (open == std::string::npos) return false;
    const std::string length = text.substr(open + 1, text.size() - open - 2);
    text.resize(open);
    if (length.empty()) {
      type.arrayLength = -1;
    } else {
      const auto [end, error] = std::from_chars(length.data(), length.data() + length.size(), type.arrayLength);
      if (error != std::errc() || end != length.data() + length.size()) return false;
      if (type.arrayLength < 1 || type.arrayLength > language::kMostElements) return false;
    }
  }
  static constexpr std::pair<const char*, Base> kNames[] = {
      {"int", Base::Int},     {"float", Base::Float},   {"string", Base::String}, {"color", Base::Color},
      {"point", Base::Point}, {"vector", Base::Vector}, {"normal", Base::Normal}, {"matrix", Base::Matrix}};
  for (const auto& [name, base] : kNames)
    if (text == name) {
      type.base = base;
      return true;
    }
  return false;
}

// A number at the front of `text`, which then begins behind it.
template <class T>
bool takeNumber(std::string_view& text, T& out) {
  while (!text.empty() && (text[0] == ' ' || text[0] == '\t' || text[0] == '\n' || text[0] == '\r'))
    text.remove_prefix(1);
  const char* first = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(first, text.data() + text.size(), out);
  if (error == std::errc::result_out_of_range && std::is_same_v<T, float>) {
    out = T(language::stof(text));  // an infinity or zero
  } else if (error != std::errc()) {
    return false;
  }
  text.remove_prefix(size_t(end - text.data()));
  return true;
}
template <class T>
bool takeList(std::string_view text, size_t count, std::vector<T>& out) {
  out.clear();
  while (out.size() < count) {
    T value;
    if (!takeNumber(text, value)) return false;
    out.push_back(value);
    if (out.size() < count && !text.starts_with(',')) return false;
    if (text.starts_with(',')) text.remove_prefix(1);
  }
  return text.empty();
}
// As many as there are, at most kMostValues.
template <class T>
bool takeAll(std::string_view text, std::vector<T>& out) {
  T value;
  while (!text.empty() && out.size() < kMostValues) {
    if (!takeNumber(text, value)) return false;
    out.push_back(value);
    if (text.starts_with(',')) text.remove_prefix(1);
  }
  return text.empty();
}

// Zeros for what is not given; an array without a length gets one.
void fitValues(Type& type, Values& values) {
  const size_t components = size_t(std::max(1, language::componentsOf(type.base)));
  const size_t given = type.base == Base::String ? values.strings.size()
                       : type.base == Base::Int  ? values.ints.size()
                                                 : values.floats.size();
  if (type.arrayLength < 0) type.arrayLength = int32_t(std::max<size_t>(1, (given + components - 1) / components));
  const size_t wanted = components * size_t(std::max(1, type.arrayLength));
  if (type.base == Base::String)
    values.strings.resize(wanted);
  else if (type.base == Base::Int)
    values.ints.resize(wanted);
  else
    values.floats.resize(wanted);
}

class GroupMaker {
 public:
  GroupMaker(const RunJob& job, RunGroup& out) : job_(job), out_(out) {}

  bool run() {
    out_.group.name = job_.groupName.empty() ? "unnamed_group_1" : job_.groupName;
    for (const GroupStep& step : job_.steps)
      if (!add(step)) return false;
    if (!pending_.empty())
      return fail(fmt::format("parameter '{}' stands behind the shader that it should set: --param comes first",
                              pending_[0].parameter));
    for (const GroupStep& step : job_.steps)
      if (step.kind == GroupStep::Connect) connect(step.words[0], step.words[1], step.words[2], step.words[3]);
    out_.group.entries = job_.entries;
    if (!job_.entryOutput.empty()) out_.group.entries = {job_.entryOutput.substr(0, job_.entryOutput.find('.'))};
    findEager();
    return true;
  }

 private:
  bool fail(const std::string& what) {
    std::fflush(stdout);
    fmt::print(stderr, "error: {}\n", what);
    return false;
  }

  bool add(const GroupStep& step) {
    switch (step.kind) {
      case GroupStep::Param:
        return parameter(step.modifiers, step.words[0], step.words[1]);
      case GroupStep::Shader:
        return shader(step.words[0]);
      case GroupStep::LayerName:
        layerName_ = step.words[0];
        return true;
      case GroupStep::Group:
        return groupText(step.words[0]);
      case GroupStep::Expression:
        return expression(step.words[0]);
      case GroupStep::Reparam:
      case GroupStep::UserData:
        return named(step);
      case GroupStep::Connect:
        return true;
    }
    return false;
  }

  // type=T:lockgeom=0: what stands behind an option's name.
  bool modifiers(const std::string& text, std::string& type, std::optional<bool>& isLocked) {
    for (size_t at = 0; at < text.size();) {
      const size_t end = std::min(text.find(':', at), text.size());
      const std::string one = text.substr(at, end - at);
      if (one.starts_with("type="))
        type = one.substr(5);
      else if (one.starts_with("lockgeom="))
        isLocked = one.substr(9) != "0";
      else if (one.starts_with("interpolated="))
        isLocked = one.substr(13) == "0";
      else if (!one.starts_with("interactive="))
        return fail(fmt::format("'{}' is no modifier: type=, lockgeom=, interpolated=, interactive=", one));
      at = end + 1;
    }
    return true;
  }
  bool parameter(const std::string& hints, const std::string& name, const std::string& text) {
    std::string typeName, error;
    std::optional<bool> isLocked;
    if (!modifiers(hints, typeName, isLocked)) return false;
    language::Setting setting;
    setting.parameter = name;
    if (!parseValue(typeName, text, setting.type, setting.values, error))
      return fail(fmt::format("parameter '{}': {}", name, error));
    pending_.push_back(std::move(setting));
    if (isLocked) hints_.push_back({name, *isLocked});
    return true;
  }
  bool named(const GroupStep& step) {
    const size_t at = step.kind == GroupStep::Reparam ? 1 : 0;
    std::string typeName, error;
    std::optional<bool> isLocked;
    NamedValue value;
    value.name = step.words[at];
    if (!modifiers(step.modifiers, typeName, isLocked)) return false;
    if (!parseValue(typeName, step.words[at + 1], value.type, value.values, error))
      return fail(fmt::format("'{}': {}", value.name, error));
    if (step.kind == GroupStep::UserData) {
      out_.userData.push_back(std::move(value));
    } else {
      out_.reparams.push_back({value.name, value.type, std::move(value.values)});
      out_.reparamLayers.push_back(step.words[0]);
    }
    return true;
  }

  bool shader(const std::string& name) {
    std::shared_ptr<const language::Shader>& known = known_[name];
    if (!known) {
      std::fflush(stdout);
      std::optional<language::Shader> loaded = loadShader(name, job_.compile, job_.path);
      if (!loaded) return false;
      known = checked(std::move(*loaded));
    }
    return layer(known);
  }
  std::shared_ptr<const language::Shader> checked(language::Shader shader) {
    return std::make_shared<const language::Shader>(
        language::instrumented(std::move(shader), job_.debugNan, job_.debugUninit));
  }
  bool layer(const std::shared_ptr<const language::Shader>& made) {
    language::Layer layer;
    layer.shader = made;
    layer.name = layerName_.empty() ? fmt::format("{}_{}", made->name, out_.group.layers.size()) : layerName_;
    for (const language::Layer& other : out_.group.layers)
      if (other.name == layer.name) return fail(fmt::format("two layers are named '{}'", layer.name));
    layer.settings = std::move(pending_);
    for (const auto& [name, isLocked] : hints_)
      (isLocked ? out_.locked : out_.unlocked).insert(layer.name + "." + name);
    out_.group.layers.push_back(std::move(layer));
    pending_.clear();
    hints_.clear();
    layerName_.clear();
    return true;
  }
  bool expression(const std::string& code) {
    const std::string name = fmt::format("expr_{}", expressions_++);
    const std::string source = "shader " + name +
                               "(float s = u [[ int lockgeom = 0 ]], float t = v [[ int lockgeom = 0 ]],\n"
                               "output color result = 0, output float alpha = 1) {\n" +
                               code + "\n;}\n";
    language::CompileResult result = language::compile(source, name, job_.compile);
    std::fflush(stdout);
    for (const language::CompileMessage& m : result.messages) fmt::print(stderr, "{}\n", m.str());
    if (!result.ok()) return false;
    return layer(checked(std::move(*result.shader)));
  }
  void connect(const std::string& fromLayer, const std::string& from, const std::string& toLayer,
               const std::string& to) {
    out_.group.connections.push_back({fromLayer, from, toLayer, to});
    out_.connections += fmt::format("Connect {}.{} to {}.{}\n", fromLayer, from, toLayer, to);
  }

  // Instructions but those of branches that a parameter of the layer decides against.
  template <class F>
  void forEachTaken(const language::Block& block, const language::Layer& layer, F&& f) {
    for (const language::Instruction& in : block.code) {
      f(in);
      bool isTrue = true, isFalse = true;
      if (in.opcode == language::Opcode::If) {
        const language::Symbol& condition = layer.shader->symbols[size_t(in.arguments[0])];
        const bool isFed = std::any_of(
            out_.group.connections.begin(), out_.group.connections.end(),
            [&](const language::Connection& c) { return c.toLayer == layer.name && c.to == condition.name; });
        if (condition.kind == language::SymbolKind::Param && condition.type.base == Base::Int && !isFed &&
            !condition.hasInitCode && condition.values.ints.size() == 1) {
          int32_t value = condition.values.ints[0];
          for (const language::Setting& s : layer.settings)
            if (s.parameter == condition.name && s.values.ints.size() == 1) value = s.values.ints[0];
          (value ? isFalse : isTrue) = false;
        }
      }
      for (size_t i = 0; i < in.blocks.size(); ++i)
        if (i == 0 ? isTrue : isFalse) forEachTaken(in.blocks[i], layer, f);
    }
  }
  // Layers that --options lazy...=0 run although nothing needs them.
  void findEager() {
    const bool lazyLayers = job_.option("lazylayers", 1), lazyGlobals = job_.option("lazyglobals", 1),
               lazyUnconnected = job_.option("lazyunconnected", 1), lazyErrors = job_.option("lazyerror", 1),
               lazyTraces = job_.option("lazytrace", 1);
    for (const language::Layer& layer : out_.group.layers) {
      bool isEager = !lazyLayers;
      if (!lazyUnconnected)
        isEager |= std::none_of(out_.group.connections.begin(), out_.group.connections.end(),
                                [&](const language::Connection& c) { return c.fromLayer == layer.name; });
      const language::Shader& shader = *layer.shader;
      forEachTaken(shader.main, layer, [&](const language::Instruction& in) {
        isEager |= !lazyErrors && in.opcode == language::Opcode::Error;
        isEager |= !lazyTraces && in.opcode == language::Opcode::Trace;
        for (uint32_t i = 0; !lazyGlobals && i < in.arguments.size(); ++i)
          isEager |= accessOf(shader, in, i) != 'r' &&
                     shader.symbols[size_t(in.arguments[i])].kind == language::SymbolKind::Global;
      });
      if (isEager && &layer != &out_.group.layers.back()) out_.group.eager.push_back(layer.name);
    }
  }

  // ---- a group as text ----

  struct Text {
    std::string_view rest;
    void blanks() {
      while (!rest.empty() && std::isspace(static_cast<unsigned char>(rest[0]))) rest.remove_prefix(1);
    }
    bool is(char c) {
      blanks();
      if (!rest.starts_with(c)) return false;
      rest.remove_prefix(1);
      return true;
    }
    bool is(std::string_view s) {
      blanks();
      if (!rest.starts_with(s)) return false;
      rest.remove_prefix(s.size());
      return true;
    }
    // Up to a blank, a ';' or one of `ends`; quoted text without its quotes.
    std::string word(std::string_view ends = {}) {
      blanks();
      std::string out;
      if (rest.starts_with('"')) {
        rest.remove_prefix(1);
        while (!rest.empty() && rest[0] != '"') {
          char c = rest[0];
          rest.remove_prefix(1);
          if (c == '\\' && !rest.empty()) {
            c = rest[0];
            rest.remove_prefix(1);
            c = c == 'n' ? '\n' : c == 't' ? '\t' : c == 'r' ? '\r' : c;
          }
          out += c;
        }
        if (!rest.empty()) rest.remove_prefix(1);
        return out;
      }
      while (!rest.empty() && !std::isspace(static_cast<unsigned char>(rest[0])) && rest[0] != ';' &&
             ends.find(rest[0]) == std::string_view::npos) {
        out += rest[0];
        rest.remove_prefix(1);
      }
      return out;
    }
  };

  bool groupText(const std::string& given) {
    std::string text = given;
    std::error_code ignored;
    if (given.size() < 4096 && fs::is_regular_file(given, ignored))
      if (const std::optional<std::string> file = language::readSourceFile(given)) text = *file;
    Text t{text};
    for (t.blanks(); !t.rest.empty(); t.blanks()) {
      if (t.is(';') || t.is(',')) continue;
      const std::string keyword = t.word();
      bool isGood = true;
      if (keyword == "param") {
        isGood = textParameter(t);
      } else if (keyword == "shader") {
        const std::string name = t.word(",");
        t.blanks();
        if (!t.rest.empty() && t.rest[0] != ';' && t.rest[0] != ',') layerName_ = t.word(",");
        isGood = !name.empty() ? shader(name) : fail("the group's text: 'shader' without a name");
      } else if (keyword == "connect") {
        const std::string from = t.word(","), to = t.word(",");
        const size_t a = from.find('.'), b = to.find('.');
        if (a == std::string::npos || b == std::string::npos)
          return fail(fmt::format("the group's text: 'connect {} {}' is not LAYER.OUTPUT LAYER.INPUT", from, to));
        out_.group.connections.push_back({from.substr(0, a), from.substr(a + 1), to.substr(0, b), to.substr(b + 1)});
      } else {
        return fail(fmt::format("the group's text: '{}' is no statement: param, shader, connect", keyword));
      }
      if (!isGood) return false;
      t.blanks();
      const bool isClosed = keyword == "param" && (t.rest.starts_with("param ") || t.rest.starts_with("shader "));
      if (!t.is(';') && !t.is(',') && !t.rest.empty() && !isClosed)
        return fail(fmt::format("the group's text: ';' is missing before '{}'", t.word()));
    }
    return true;
  }
  bool textParameter(Text& t) {
    const std::string typeName = t.word(), name = t.word();
    language::Setting setting;
    setting.parameter = name;
    if (!typeNamed(typeName, setting.type))
      return fail(fmt::format("the group's text: '{}' is no type of a parameter", typeName));
    const size_t components = size_t(std::max(1, language::componentsOf(setting.type.base)));
    const size_t most =
        setting.type.arrayLength < 0 ? kMostValues : components * size_t(std::max(1, setting.type.arrayLength));
    Values& v = setting.values;
    for (size_t n = 0;; ++n) {
      t.is(',');
      t.blanks();
      if (t.rest.empty() || t.rest[0] == ';' || t.rest.starts_with("[[")) break;
      // a comma may end the statement too
      const bool isNext =
          t.rest.starts_with("param ") || t.rest.starts_with("shader ") || t.rest.starts_with("connect ");
      if (isNext && n > 0) break;
      if (n >= most) return fail(fmt::format("the group's text: too many values for {} {}", typeName, name));
      if (setting.type.base == Base::String) {
        v.strings.push_back(t.word(","));
      } else {
        const std::string number = t.word(",[");
        std::string_view rest = number;
        bool isGood = true;
        if (setting.type.base == Base::Int)
          isGood = takeNumber(rest, v.ints.emplace_back());
        else
          isGood = takeNumber(rest, v.floats.emplace_back());
        if (!isGood || !rest.empty())
          return fail(fmt::format("the group's text: '{}' is no value of {} {}", number, typeName, name));
      }
    }
    if (t.is("[[")) {
      while (!t.rest.empty() && !t.is("]]")) {
        t.word(",]");  // the hint's type
        const std::string hint = t.word("=,]");
        const std::string value = t.is('=') ? t.word(",]") : "";
        if (hint == "lockgeom") hints_.push_back({name, value != "0"});
        if (hint == "interpolated") hints_.push_back({name, value == "0"});
        t.is(',');
        if (hint.empty() && value.empty() && !t.rest.starts_with("]]"))
          return fail(fmt::format("the group's text: the hints of {} are not closed", name));
      }
    }
    fitValues(setting.type, setting.values);
    pending_.push_back(std::move(setting));
    return true;
  }

  const RunJob& job_;
  RunGroup& out_;
  std::vector<language::Setting> pending_;
  std::vector<std::pair<std::string, bool>> hints_;
  std::string layerName_;
  std::map<std::string, std::shared_ptr<const language::Shader>> known_;
  int expressions_ = 0;
};

}  // namespace

bool parseValue(const std::string& typeName, const std::string& text, Type& type, Values& values,
                std::string& error) {
  values = {};
  const bool isFree = typeName.empty();
  type = {};
  if (!isFree && !typeNamed(typeName, type)) {
    error = "'" + typeName + "' is no type of a parameter";
    return false;
  }
  if (isFree) {
    if (takeList(text, 16, values.floats)) {
      type.base = Base::Matrix;
    } else if (takeList(text, 3, values.floats)) {
      type.base = Base::Vector;
    } else if (values.floats.clear(), takeList(text, 1, values.ints)) {
      type.base = Base::Int;
    } else if (values.ints.clear(), takeList(text, 1, values.floats)) {
      type.base = Base::Float;
    } else {
      values.floats.clear();
      type.base = Base::String;
      values.strings = {text};
    }
    return true;
  }
  bool isGood = true;
  if (type.base == Base::String) {
    if (type.arrayLength == 0) {
      values.strings = {text};
    } else {
      for (size_t at = 0; at <= text.size() && values.strings.size() < kMostValues;) {
        const bool isLast = type.arrayLength > 0 && values.strings.size() + 1 == size_t(type.arrayLength);
        const size_t end = isLast ? text.size() : std::min(text.find(',', at), text.size());
        values.strings.push_back(text.substr(at, end - at));
        at = end + 1;
      }
    }
  } else if (type.base == Base::Int) {
    isGood = takeAll(text, values.ints);
  } else {
    isGood = takeAll(text, values.floats);
  }
  const size_t given = std::max(values.ints.size(), values.floats.size());
  const size_t most = size_t(std::max(1, language::componentsOf(type.base))) * size_t(std::max(1, type.arrayLength));
  if (!isGood || (type.base != Base::String && given == 0) || (type.arrayLength >= 0 && given > most)) {
    error = "'" + text + "' is no value of type " + typeName;
    return false;
  }
  fitValues(type, values);
  return true;
}

bool makeGroup(const RunJob& job, RunGroup& out) { return GroupMaker(job, out).run(); }

std::string serialised(const RunGroup& run) {
  std::string text;
  for (const language::Layer& layer : run.group.layers) {
    for (const language::Setting& s : layer.settings) {
      text += fmt::format("param {} {}", nameOf(s.type), s.parameter);
      for (const int32_t i : s.values.ints) text += fmt::format(" {}", i);
      for (const float f : s.values.floats) text += " " + language::nineDigits(f);
      for (const std::string& v : s.values.strings) text += " " + language::inQuotes(v);
      const std::string full = layer.name + "." + s.parameter;
      if (run.unlocked.count(full)) text += " [[int lockgeom=0]]";
      text += " ;\n";
    }
    text += fmt::format("shader {} {} ;\n", layer.shader->name, layer.name);
    for (const language::Connection& c : run.group.connections)
      if (c.toLayer == layer.name)
        text += fmt::format("connect {}.{} {}.{} ;\n", c.fromLayer, c.from, c.toLayer, c.to);
  }
  return text;
}

}  // namespace kinora::app

// `kinora shader info`: parameters of shaders, laid out as `oslinfo` does (reference: osl-numerics, section 13).
#include <fmt/format.h>

#include <cstdio>

#include "app/command_line.h"
#include "app/exit_codes.h"
#include "app/shader_commands.h"
#include "language/program/quoted.h"

namespace kinora::app {

namespace {

using language::Base;
using language::Metadata;
using language::nameOf;
using language::Shader;
using language::Symbol;
using language::SymbolKind;
using language::Values;

constexpr const char* kInfoHelp =
    R"(kinora shader info [options] SHADER ...: parameters of shaders (.osl, .oso)

  -v            with metadata
  --param NAME  this parameter only
  --ir          the intermediate form
  --count       how many parameters, symbols and operations
  -I DIR, -D NAME[=VALUE], -U NAME  for source, as `kinora shader compile` takes them
)";

std::string numbers(const Values& v) {
  std::string s;
  for (const int i : v.ints) s += fmt::format(" {}", i);
  for (const float f : v.floats) {
    char text[32];
    std::snprintf(text, sizeof text, " %g", double(f));
    s += text;
  }
  return s;
}

void printMetadata(const std::vector<Metadata>& list) {
  for (const Metadata& m : list) {
    std::string s = numbers(m.values);
    for (const std::string& v : m.values.strings) s += " " + language::inQuotes(v);
    fmt::print("\t\tmetadata: {} {} ={}\n", nameOf(m.type), m.name, s);
  }
}

void printDefault(const Symbol& p, bool isVerbose) {
  if (p.hasInitCode || p.type.base == Base::Closure) {
    fmt::print("{}", isVerbose ? "\t\tUnknown default value\n" : "nodefault\n");
    return;
  }
  const bool isMany = p.type.arrayLength != 0 || componentsOf(p.type.base) > 1;
  if (p.type.base == Base::String) {
    if (isVerbose) {
      for (const std::string& s : p.values.strings) fmt::print("\t\tDefault value: {}\n", language::inQuotes(s));
    } else {
      for (const std::string& s : p.values.strings) fmt::print("{} ", language::inQuotes(s));
      fmt::print("\n");
    }
    return;
  }
  const std::string s = numbers(p.values);
  fmt::print("{}{}{}{}\n", isVerbose ? "\t\tDefault value:" : "", isMany ? " [" : "", s, isMany ? " ]" : "");
}

void printParameter(const Shader& shader, const Symbol& p, bool isVerbose) {
  const bool isStruct = p.type.base == Base::Struct;
  const std::string type = isStruct ? "struct " + shader.structures[size_t(p.type.structure)].name +
                                          nameOf({Base::Void, p.type.arrayLength, -1}).substr(4)
                                    : nameOf(p.type);
  const char* output = p.kind == SymbolKind::OutputParam ? "output " : "";
  if (isVerbose)
    fmt::print("    \"{}\" \"{}{}\"\n", p.name, output, type);
  else
    fmt::print("{}{} {} ", output, type, p.name);
  if (isStruct) {
    std::string fields;
    for (const language::Field& f : shader.structures[size_t(p.type.structure)].fields) {
      language::Type t = f.type;
      const std::string fieldType =
          t.base == Base::Struct ? "struct " + shader.structures[size_t(t.structure)].name : nameOf(t);
      fields += (fields.empty() ? "" : ", ") + fieldType + " " + f.name;
    }
    fmt::print("{}fields: {{{}}}\n", isVerbose ? "\t\t" : "", fields);
  } else {
    printDefault(p, isVerbose);
  }
  if (isVerbose) printMetadata(p.metadata);
}

size_t operationsOf(const language::Block& block) {
  size_t n = block.code.size();
  for (const language::Instruction& i : block.code)
    for (const language::Block& b : i.blocks) n += operationsOf(b);
  return n;
}

void printCounts(const Shader& shader) {
  size_t parameters = 0, outputs = 0, constants = 0, operations = operationsOf(shader.main);
  for (const Symbol& s : shader.symbols) {
    if (s.ofStruct == language::kNone) {
      parameters += s.kind == SymbolKind::Param;
      outputs += s.kind == SymbolKind::OutputParam;
    }
    constants += s.kind == SymbolKind::Constant;
  }
  for (const language::Initialiser& i : shader.initialisers) operations += operationsOf(i.code);
  fmt::print("parameters {}\noutputs {}\nsymbols {}\nconstants {}\noperations {}\n", parameters, outputs,
             shader.symbols.size(), constants, operations);
}

}  // namespace

int runShaderInfo(const Arguments& arguments) {
  Diagnostics diagnostics;
  language::CompileOptions options;
  options.withWarnings = false;
  std::vector<std::string> names;
  std::string only, value;
  bool isVerbose = false, hasIr = false, hasCount = false;
  ShaderOptions o(arguments);
  while (o.next()) {
    if (!o.isOption()) {
      names.push_back(o.word());
    } else if (o.is("help") || o.is("h")) {
      fmt::print("{}", kInfoHelp);
      return kComplete;
    } else if (o.is("v")) {
      isVerbose = true;
    } else if (o.is("ir")) {
      hasIr = true;
    } else if (o.is("count")) {
      hasCount = true;
    } else if (o.is("param")) {
      o.value(only);
    } else if (o.letter('I', value)) {
      options.includePaths.push_back(value);
    } else if (o.letter('D', value)) {
      options.defines.push_back(value);
    } else if (o.letter('U', value)) {
      options.undefines.push_back(value);
    } else if (!o.isMissing()) {
      return badCommandLine(diagnostics, "unknown option '-" + o.word() + "'", "see `kinora shader info --help`");
    }
    if (o.isMissing()) return badCommandLine(diagnostics, "option -" + o.word() + " needs a value");
  }
  if (names.empty()) return badCommandLine(diagnostics, "no shader is given", "see `kinora shader info --help`");
  int worst = kComplete;
  for (const std::string& name : names) {
    const std::optional<Shader> shader = loadShader(name, options);
    if (!shader) {
      worst = 1;
      continue;
    }
    if (hasIr) fmt::print("{}", toText(*shader));
    if (hasCount) printCounts(*shader);
    if (hasIr || hasCount) continue;
    static constexpr const char* kKinds[] = {"shader", "surface", "displacement", "volume"};
    if (only.empty()) {
      fmt::print("{} \"{}\"\n", kKinds[size_t(shader->kind)], shader->name);
      if (isVerbose) printMetadata(shader->metadata);
    }
    bool isFound = only.empty();
    for (const Symbol& s : shader->symbols) {
      const bool isParameter = s.kind == SymbolKind::Param || s.kind == SymbolKind::OutputParam;
      if (!isParameter || (only.empty() ? s.ofStruct != language::kNone : s.name != only)) continue;
      printParameter(*shader, s, isVerbose);
      isFound = true;
    }
    if (!isFound) {
      fmt::print(stderr, "{}: error: shader '{}' has no parameter '{}'\n", name, shader->name, only);
      worst = 1;
    }
  }
  return worst;
}

}  // namespace kinora::app

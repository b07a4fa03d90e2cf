// What the front end's tests share: compiling text with files that exist in the test only.
#pragma once
#include <gtest/gtest.h>

#include <map>
#include <string>

#include "language/front/compile.h"

namespace kinora::language {

struct Compiled {
  CompileResult result;
  std::string errors, warnings;  // "LINE:COLUMN text\n" each
  std::string ir;                // toText() of what was compiled
  bool says(const std::string& text) const {
    return errors.find(text) != std::string::npos || warnings.find(text) != std::string::npos;
  }
  bool has(const std::string& text) const { return ir.find(text) != std::string::npos; }
};

inline Compiled compiled(const std::string& source, const std::map<std::string, std::string>& files = {},
                         CompileOptions options = {}) {
  Compiled c;
  c.result = compile(source, "t.osl", options, [&](const std::string& path) -> std::optional<std::string> {
    const auto at = files.find(path);
    return at == files.end() ? std::nullopt : std::optional(at->second);
  });
  for (const CompileMessage& m : c.result.messages)
    (m.severity == Severity::Error ? c.errors : c.warnings) +=
        std::to_string(m.pos.line) + ":" + std::to_string(m.column) + " " + m.text + "\n";
  if (c.result.ok()) {
    EXPECT_EQ(invalid(*c.result.shader), "") << source;
    c.ir = toText(*c.result.shader);
  }
  return c;
}

// Statements inside of a shader with two outputs.
inline Compiled statements(const std::string& code, const std::string& before = {}) {
  return compiled(before + "\nsurface t(output float f = 0, output color c = 0) {\n" + code + "\n}\n");
}

}  // namespace kinora::language

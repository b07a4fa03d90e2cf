// Runs a program of the group machine once, before the mock renderer.
#pragma once
#include <map>
#include <string>
#include <vector>

#include "language/mock_renderer.h"
#include "language/vm/test_runner.h"

namespace kinora::oracle {

struct Ran {
  std::map<std::string, std::vector<float>> values;  // "name" or "name.0"
  std::vector<MockRenderer::Message> messages;
};

// Parameters that vary get their default at each point. The points are shifted by what the mock renderer is told too.
Ran runOnce(const language::Executable& program, const language::ShaderGroup& group,
            const language::testing::Points& points, float shiftU = 0, float shiftV = 0);

}  // namespace kinora::oracle

// SPDX-License-Identifier: Apache-2.0
// The fuzzers' entry functions over their corpus and over seeded mutations of it: what ./run test has of the fuzzing
// that
// ./run prove fuzz does at length. A broken promise ends the program; the sanitizers watch.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "base/bytes.h"
#include "base/random.h"
#include "tests/fuzz/targets.h"

namespace soak::fuzz {
namespace {

using Target = bool (*)(Input);

std::vector<base::Bytes> corpus(const std::string& name) {
  std::vector<std::filesystem::path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(SOAK_TEST_FOLDER "/fuzz/corpus/" + name)) {
    paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  std::vector<base::Bytes> inputs;
  for (const auto& path : paths) {
    std::ifstream in(path, std::ios::binary);
    inputs.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  return inputs;
}

std::size_t index(base::Random& random, std::size_t size) { return static_cast<std::size_t>(random.next() % size); }

/// A few bytes changed, a piece taken out, or a piece of another input put in.
base::Bytes mutated(const std::vector<base::Bytes>& inputs, base::Random& random) {
  base::Bytes bytes = inputs[index(random, inputs.size())];
  const base::Bytes& other = inputs[index(random, inputs.size())];
  if (bytes.empty() || other.empty()) return bytes;
  const auto at = static_cast<std::ptrdiff_t>(index(random, bytes.size()));
  const auto from = static_cast<std::ptrdiff_t>(index(random, other.size()));
  const auto longest =
      static_cast<std::size_t>(std::min(bytes.end() - (bytes.begin() + at), other.end() - (other.begin() + from)));
  const auto length = static_cast<std::ptrdiff_t>(index(random, std::min<std::size_t>(longest, 64)));
  switch (random.next() % 4) {
    case 0:
      bytes.erase(bytes.begin() + at, bytes.begin() + at + length);
      break;
    case 1:
      bytes.insert(bytes.begin() + at, other.begin() + from, other.begin() + from + length);
      break;
    case 2:
      std::copy_n(other.begin() + from, length, bytes.begin() + at);
      break;
    default:
      for (int i = 0; i < 3; ++i)
        bytes[index(random, bytes.size())] ^= static_cast<std::uint8_t>(1U << random.next() % 8);
  }
  return bytes;
}

/// Runs the target over the corpus and `runs` mutations; some of either must be accepted and some refused, else the
/// test would see one side of the reader only.
void run(Target target, const std::string& name, int runs) {
  const auto inputs = corpus(name);
  ASSERT_FALSE(inputs.empty());
  std::size_t accepted = 0;
  for (const base::Bytes& input : inputs) accepted += target(input) ? 1 : 0;
  EXPECT_GT(accepted, 0U);
  EXPECT_LT(accepted, inputs.size());
  base::Random random(1);
  int accepted_mutations = 0;
  for (int i = 0; i < runs; ++i) accepted_mutations += target(mutated(inputs, random)) ? 1 : 0;
  EXPECT_GT(accepted_mutations, 0);
  EXPECT_LT(accepted_mutations, runs);
}

TEST(FuzzCorpus, RuntimeAndDecoderKeepTheirPromises) { run(runtime_load, "runtime_load", 4000); }

TEST(FuzzCorpus, CsvReaderKeepsItsPromises) { run(csv_recording, "csv_recording", 4000); }

TEST(FuzzCorpus, ProcedureAndColumnsMapReadersKeepTheirPromises) { run(procedure, "procedure", 2000); }

TEST(FuzzCorpus, MapsOfControllersKeepTheirPromises) { run(controller_map, "controller_map", 4000); }

TEST(FuzzCorpus, AnswersOfChambersKeepTheirPromises) { run(text_answer, "text_answer", 4000); }

TEST(FuzzCorpus, XbusDecoderKeepsItsPromises) { run(xbus, "xbus", 20000); }

TEST(FuzzCorpus, MtData2DecoderKeepsItsPromises) { run(mt_data2, "mt_data2", 20000); }

TEST(FuzzCorpus, Ahrs400DecoderKeepsItsPromises) { run(ahrs400, "ahrs400", 20000); }

TEST(FuzzCorpus, VectorNavDecoderKeepsItsPromises) { run(vectornav, "vectornav", 20000); }

}  // namespace
}  // namespace soak::fuzz

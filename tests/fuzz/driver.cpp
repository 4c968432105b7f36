// Runs a fuzz target without libFuzzer: over the files of its corpus, then over so many mutations of
// them, the same ones every time.
// usage: fuzz_<target> CORPUS_FOLDER N_MUTATIONS
#include "fuzz.hpp"

#include <algorithm>
#include <csignal>
#include <exception>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <sys/resource.h>
#include <unistd.h>
#include <vector>

namespace {

std::string input;  // what runs at the moment

/// Leaves the input that ended the process in the folder in which it ran.
extern "C" void keep_input(int signal) {
  std::signal(signal, SIG_DFL);
  std::ofstream("fuzz_failure", std::ios::binary) << input;
  std::raise(signal);
}

class Mutator {
 public:
  explicit Mutator(std::vector<std::string> corpus) : corpus_(std::move(corpus)) {}

  std::string next() {
    std::string text = any(corpus_);
    for (std::size_t n = 1 + below(6); n > 0; --n) change(text);
    return text;
  }

 private:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : engine_() % n; }
  template <class T>
  const T& any(const std::vector<T>& items) {
    return items[below(items.size())];
  }

  void change(std::string& text) {
    static const std::vector<std::string> words = {"0",
                                                   "-1",
                                                   "1e999",
                                                   "nan",
                                                   "99999999999999999999",
                                                   "0.5",
                                                   ",",
                                                   ".",
                                                   "\"",
                                                   ":",
                                                   ": ",
                                                   "[",
                                                   "]",
                                                   "{",
                                                   "}",
                                                   "- ",
                                                   "\n",
                                                   "\t",
                                                   "#",
                                                   "&a ",
                                                   "*a",
                                                   "null",
                                                   "~",
                                                   "!!x ",
                                                   "---\n",
                                                   "\\",
                                                   "=",
                                                   std::string(1, '\0'),
                                                   "\xC2\xA0",
                                                   "\xE2\x80\x8B",
                                                   "\xE2\x88\x92",
                                                   "\xFF",
                                                   " mm",
                                                   " N",
                                                   "$End",
                                                   "%",
                                                   "|\n",
                                                   "'"};
    const std::size_t at = below(text.size() + 1);
    const std::size_t length = std::min(text.size() - at, 1 + below(16));
    switch (below(7)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        break;
      case 1:
        text.insert(at, 1, static_cast<char>(below(256)));
        break;
      case 2:
        text.erase(at, length);
        break;
      case 3:
        text.insert(at, text.substr(at, length));
        break;
      case 4:
        text.insert(at, any(words));
        break;
      case 5:
        text.replace(at, length, any(words));
        break;
      default: {
        const std::string& other = any(corpus_);
        const std::size_t from = below(other.size() + 1);
        text = text.substr(0, at) + other.substr(from, 1 + below(200)) + text.substr(at + length);
      }
    }
  }

  std::vector<std::string> corpus_;
  std::mt19937_64 engine_{20030914};
};

void run(const std::string& text) {
  input = text;
  LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS}) std::signal(signal, keep_input);
  constexpr rlim_t most_memory = rlim_t{2} << 30;  // a small input may not take more
  const rlimit limit{most_memory, most_memory};
  setrlimit(RLIMIT_AS, &limit);
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(argv[1])) files.push_back(entry);
  std::ranges::sort(files);
  std::vector<std::string> corpus;
  for (const auto& path : files) {
    std::ifstream file(path, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
    run(corpus.back());
  }
  if (corpus.empty()) return 2;
  const int n_mutations = std::atoi(argv[2]);
  Mutator mutator(corpus);
  for (int i = 0; i < n_mutations; ++i) run(mutator.next());
  std::printf("%zu files, %d mutations\n", corpus.size(), n_mutations);
  return 0;
}

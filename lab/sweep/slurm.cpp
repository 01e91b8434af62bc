#include "lab/sweep/slurm.h"

#include <cctype>
#include <string>

#include "cx/base/number_text.h"
#include "cx/journal/run_folder.h"
#include "lab/sweep/suite.h"

namespace cxlab::lab {

namespace {

namespace fs = std::filesystem;

/// Tasks of an array that Slurm takes unless it is configured otherwise: MaxArraySize is 1001, and counts from 0.
constexpr std::size_t kMostTasks = 1000;

fs::path whole_path(const fs::path& path) { return fs::absolute(path).lexically_normal(); }

Status write_script(const fs::path& file, const std::string& text) {
  if (Status s = replace_file(file, text); !s) return s;
  std::error_code error;
  fs::permissions(file, fs::perms::owner_exec | fs::perms::group_exec, fs::perm_options::add, error);
  return error ? Status(resource_error("cannot be made executable: " + error.message(), file.string())) : Status();
}

/// A path in a line `#SBATCH --output=`, in which Slurm replaces `%`.
std::string sbatch_path(const fs::path& path) {
  std::string out;
  for (const char c : path.string()) out += c == '%' ? std::string("%%") : std::string(1, c);
  return out;
}

}  // namespace

Expected<SlurmScripts> write_slurm(const SlurmOptions& options) {
  const fs::path folder = whole_path(options.folder), scripts = folder / "slurm";
  if (folder.string().find_first_of(" \t\n") != std::string::npos)
    return input_error("Slurm takes no path with blanks for its logs; use --out with another folder", folder.string());
  SlurmScripts out{scripts / "cells.sh", scripts / "collect.sh", scripts / "submit.sh"};
  const std::size_t wanted = options.tasks > 0 ? options.tasks : kMostTasks;
  out.cells_of_task = (options.cells + wanted - 1) / wanted;
  out.tasks = (options.cells + out.cells_of_task - 1) / out.cells_of_task;
  if (Status s = make_folder(scripts); !s) return s.error();

  const std::string name = whole_path(options.suite).stem().string();
  std::string job_name = "cxlab-";
  for (const char c : name) job_name += std::isalnum(static_cast<unsigned char>(c)) ? c : '-';
  const std::string bench =
      shell_word(whole_path(options.program).string()) + " bench " + shell_word(whole_path(options.suite).string());
  std::string limits;
  if (options.time_limit_s > 0) limits += " --time-limit " + general_text(options.time_limit_s, 10);
  for (const std::string& word : options.more) limits += ' ' + shell_word(word);
  const std::string per = std::to_string(out.cells_of_task), all = std::to_string(options.cells);
  if (Status s = write_script(out.cells,
                              "#!/bin/bash\n"
                              "# Plays the cells of a sweep, " +
                                  per +
                                  " a task. submit.sh submits it.\n"
                                  "#SBATCH --job-name=" +
                                  job_name +
                                  "\n"
                                  "#SBATCH --array=1-" +
                                  std::to_string(out.tasks) +
                                  "\n"
                                  "#SBATCH --ntasks=1\n"
                                  "#SBATCH --cpus-per-task=" +
                                  std::to_string(options.jobs) +
                                  "\n"
                                  "#SBATCH --output=" +
                                  sbatch_path(scripts) +
                                  "/%A_%a.log\n"
                                  "first=$(( (SLURM_ARRAY_TASK_ID - 1) * " +
                                  per +
                                  " + 1 ))\n"
                                  "last=$(( SLURM_ARRAY_TASK_ID * " +
                                  per +
                                  " ))\n"
                                  "if [ \"$last\" -gt " +
                                  all + " ]; then last=" + all +
                                  "; fi\n"
                                  "exec " +
                                  bench + " --cell \"$first..$last\" -j " + std::to_string(options.jobs) + limits +
                                  " --out " + shell_word(folder.string()) + "\n");
      !s)
    return s.error();
  if (Status s = write_script(out.collect,
                              "#!/bin/bash\n"
                              "# Collects the rows of a sweep and prints its table. submit.sh submits it.\n"
                              "#SBATCH --job-name=" +
                                  job_name +
                                  "-table\n"
                                  "#SBATCH --ntasks=1\n"
                                  "#SBATCH --output=" +
                                  sbatch_path(scripts) +
                                  "/table.txt\n"
                                  "exec " +
                                  bench + " --collect " + shell_word(folder.string()) + " --out " +
                                  shell_word(folder.string()) + "\n");
      !s)
    return s.error();
  if (Status s = write_script(out.submit,
                              "#!/bin/bash\n"
                              "# Submits the array of cells, and the collector that runs after it. Arguments\n"
                              "# are handed on to sbatch: submit.sh --partition=short --time=30\n"
                              "set -euo pipefail\n"
                              "cells=$(sbatch --parsable \"$@\" " +
                                  shell_word(out.cells.string()) +
                                  ")\n"
                                  "table=$(sbatch --parsable --dependency=\"afterany:${cells%%;*}\" \"$@\" " +
                                  shell_word(out.collect.string()) +
                                  ")\n"
                                  "echo \"cells: job ${cells%%;*}, table: job ${table%%;*}\"\n");
      !s)
    return s.error();
  return out;
}

}  // namespace cxlab::lab

#ifndef CXLAB_BENCHMARKS_RULES_BASELINE_H
#define CXLAB_BENCHMARKS_RULES_BASELINE_H
// Plain CLIPS: the rule of the benchmark with functions that return constants.

#ifdef __cplusplus
extern "C" {
#endif

struct Baseline;

/// Null if the rules do not load.
struct Baseline* baseline_create(const char* deftemplate, const char* rule);
/// Asserts one message fact and runs; what has fired.
long long baseline_cycle(struct Baseline* baseline);
void baseline_destroy(struct Baseline* baseline);

#ifdef __cplusplus
}
#endif

#endif

#include "lab/statistics/distributions.h"

#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace cxlab::statistics {

double normal_below(double z) { return boost::math::cdf(boost::math::normal(), z); }
double normal_quantile(double p) { return boost::math::quantile(boost::math::normal(), p); }
double student_below(double t, double freedom) { return boost::math::cdf(boost::math::students_t(freedom), t); }
double student_quantile(double p, double freedom) { return boost::math::quantile(boost::math::students_t(freedom), p); }

}  // namespace cxlab::statistics

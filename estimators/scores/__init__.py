"""Statistics that judge estimators over many drives; every figure comes with its confidence interval.

A drive is the independent unit everywhere: samples within one drive are correlated and never counted as independent.
NaN is a missing sample; input without any sample is refused. Nothing here is an estimator, nothing reads a file.

interval       `Interval` and the exact or Student intervals of a mean, a root mean square, a share, a rate, a quantile
bootstrap      BCa interval of any statistic, by resampling whole drives
accuracy       RMSE, bias, standard deviation, over all time and at each time; 5-95 % band; settling times
consistency    NEES and the share of errors within 1 and 2 reported standard deviations
survival       times to an event with censoring: Kaplan-Meier curve with its band, quantiles, probability by a limit
detection      times from a fault's onset to its alarm; isolation rate and confusion of the wheels meant
false_alarms   count, hours and Poisson rate; alarms that belong together
tail           generalised Pareto tail of a statistic: threshold at a designed false-alarm rate, rate at a threshold
roc            ROC, DET and area under the curve; operating point at a given share of false alarms
"""

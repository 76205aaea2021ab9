-- Metrics of every trial of a study in SQL. Definitions: docs/analysis.md. The script replaces $names by numbers.
-- k numbers the trials, i the samples of a trial.

CREATE OR REPLACE TEMP TABLE read AS
SELECT participant::VARCHAR AS participant, session::VARCHAR AS session, trial, file_index::INTEGER AS k,
       file_row_number::INTEGER AS i, t_s AS t, theta_rad AS x, theta_dot_rad_s AS v, force_ex_n AS held,
       force_age_s::DOUBLE AS age, force_cmd_n AS cmd, voltage_motor_v::DOUBLE AS motor_v,
       environment = '$walled' AS walled, mode IN ($motor_alone) AS by_motor_alone,
       (state_bits & $motor_on) <> 0 OR voltage_motor_v <> 0 AS driven,
       (state_bits & $brake_on) <> 0 OR voltage_brake_v <> 0 AS braked
FROM read_parquet($files, hive_partitioning = true, file_row_number = true)
WHERE kind = 'trial';

-- Where a new value of the force came, and when it was taken; those that come before the last one are left out.
CREATE OR REPLACE TEMP TABLE updates AS
WITH stepped AS (
    SELECT k, i, t, held, age, lag(t) OVER w AS t0, lag(age) OVER w AS age0
    FROM read WINDOW w AS (PARTITION BY k ORDER BY i)
), fresh AS (
    SELECT k, i, t - age AS taken, held AS y FROM stepped WHERE t0 IS NULL OR age < age0 + (t - t0) / 2
), risen AS (
    SELECT *, max(taken) OVER (PARTITION BY k ORDER BY i ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING) AS latest
    FROM fresh
)
SELECT k, taken, y, lag(taken) OVER w AS taken0, lag(y) OVER w AS y0
FROM risen WHERE latest IS NULL OR taken > latest WINDOW w AS (PARTITION BY k ORDER BY i);

-- The force at each sample: straight lines between updates, the last one's after it.
CREATE OR REPLACE TEMP TABLE forced AS
WITH ends AS (SELECT k, max_by(y, taken) AS y FROM updates GROUP BY k)
SELECT r.* EXCLUDE (held, age),
       CASE WHEN u.k IS NULL THEN e.y WHEN u.taken = r.t THEN u.y
            ELSE u.y0 + (r.t - u.taken0) / (u.taken - u.taken0) * (u.y - u.y0) END AS f
FROM read r ASOF LEFT JOIN updates u ON r.k = u.k AND r.t <= u.taken JOIN ends e ON r.k = e.k;

CREATE OR REPLACE TEMP TABLE phases AS
WITH fast AS (
    SELECT k, min(i) FILTER (abs(v) > $onset) AS onset, max(i) FILTER (abs(v) > $onset) AS last, count(*) AS n
    FROM forced GROUP BY k
), ended AS (
    SELECT k, any_value(onset) AS onset, any_value(n) AS n, min(i) FILTER (i >= last AND abs(v) < $offset) AS ended
    FROM forced JOIN fast USING (k) GROUP BY k
), moved AS (
    SELECT k, max(x) FILTER (i BETWEEN onset AND coalesce(ended, n - 1)) AS top, min(x) AS lowest, max(x) AS highest
    FROM forced JOIN ended USING (k) GROUP BY k
), turned AS (
    SELECT k, any_value(onset) AS onset, any_value(ended) AS ended, any_value(n) AS n, any_value(lowest) AS lowest,
           any_value(highest) AS highest, any_value(top) AS top, any_value(coalesce(ended, n - 1)) AS "end",
           min(i) FILTER (x = top AND i BETWEEN onset AND coalesce(ended, n - 1)) AS reversal
    FROM forced JOIN ended USING (k) JOIN moved USING (k) GROUP BY k
), returned AS (
    SELECT k, min(i) AS returns FROM forced JOIN turned USING (k)
    WHERE i BETWEEN reversal AND "end" AND v < -$onset GROUP BY k
), staying AS (
    SELECT k, max(i) + 1 AS begins FROM forced JOIN turned USING (k) JOIN returned USING (k)
    WHERE i >= reversal AND i < returns AND v >= -$offset GROUP BY k
)
SELECT turned.*, CASE WHEN returns IS NOT NULL THEN greatest(reversal, begins) END AS begins
FROM turned LEFT JOIN returned USING (k) LEFT JOIN staying USING (k);

-- Each sample beside the one before.
CREATE OR REPLACE TEMP TABLE samples AS
SELECT *, x > $wall AS past, i BETWEEN onset AND reversal AS way, i BETWEEN reversal AND "end" AS back,
       i BETWEEN onset AND reversal AND x - $rest >= $slope_from AND (NOT walled OR x < $wall) AS pressing,
       i > onset AND i <= "end" AS moving, $retreat * (highest - lowest) AS retreat,
       x > $wall AND abs(v) < $offset AS still,
       lag(t) OVER w AS t0, lag(x) OVER w AS x0, lag(v) OVER w AS v0, lag(f) OVER w AS f0, lag(braked) OVER w AS braked0,
       lag(driven) OVER w AS driven0, lag(cmd) OVER w AS cmd0, lag(motor_v) OVER w AS motor_v0
FROM forced JOIN phases USING (k) WINDOW w AS (PARTITION BY k ORDER BY i);

-- Arrivals: at each stop and at the wall the lever is from when it comes there until it has retreated.
CREATE OR REPLACE TEMP TABLE arrivals AS
WITH told AS (
    SELECT k, i, CASE WHEN x <= $low THEN true WHEN x - $low > retreat THEN false END AS low,
           CASE WHEN x >= $high THEN true WHEN $high - x > retreat THEN false END AS high,
           CASE WHEN x > $wall THEN true WHEN x < $wall - retreat THEN false END AS wall
    FROM samples
), held AS (
    SELECT k, i, coalesce(last_value(low IGNORE NULLS) OVER w, false) AS low,
           coalesce(last_value(high IGNORE NULLS) OVER w, false) AS high,
           coalesce(last_value(wall IGNORE NULLS) OVER w, false) AS wall
    FROM told WINDOW w AS (PARTITION BY k ORDER BY i ROWS BETWEEN UNBOUNDED PRECEDING AND CURRENT ROW)
), stepped AS (
    SELECT *, lag(low) OVER w AS low0, lag(high) OVER w AS high0, lag(wall) OVER w AS wall0
    FROM held WINDOW w AS (PARTITION BY k ORDER BY i)
)
SELECT k, count(*) FILTER (low AND NOT low0) AS work_space_hits_low,
       count(*) FILTER (high AND NOT high0) AS work_space_hits_high,
       count(*) FILTER (wall AND NOT coalesce(wall0, false)) AS contacts
FROM stepped GROUP BY k;

CREATE OR REPLACE TEMP TABLE scalars AS
WITH parts AS (
    SELECT *, ($wall - x0) / (x - x0) AS passes, CASE WHEN x0 > $wall THEN 0.0 ELSE ($wall - x0) / (x - x0) END AS a,
           CASE WHEN past THEN 1.0 ELSE ($wall - x0) / (x - x0) END AS b, past OR x0 > $wall AS "either"
    FROM samples
), sums AS (
    SELECT k, any_value(participant) AS participant, any_value(session) AS session, any_value(trial) AS trial,
        any_value(walled) AS walled, any_value(by_motor_alone) AS by_motor_alone, min(x) AS theta_min_rad,
        max(f) FILTER (i = begins) AS return_force_n,
        count(*) FILTER (moving AND driven <> driven0) AS motor_switches,
        count(*) FILTER (moving AND braked <> braked0) AS brake_switches,
        count(*) FILTER (moving AND (driven <> driven0 OR braked <> braked0)) AS actuator_switches,
        sum(abs(cmd0) * (t - t0)) AS commanded,
        sum(motor_v0 ** 2 * (t - t0)) / $motor_ohm
            + $lever * coalesce(sum(abs(cmd0) * abs(x - x0)) FILTER (motor_v0 <> 0), 0) AS bound,
        any_value(reversal) + 1 < any_value(n) AS goes_on,
        max(t) FILTER (i = onset) AS onset_s, max(t) FILTER (i = reversal) AS reversal_s,
        max(t) FILTER (i = ended) AS end_s, max(t) FILTER (i = "end") AS last_s, max(x) AS theta_max_rad,
        sum((t - t0) * (abs(v) + abs(v0)) / 2) FILTER (way AND i > onset) AS forward,
        sum((t - t0) * (abs(v) + abs(v0)) / 2) FILTER (back AND i > reversal) AS backward,
        max(abs(v)) FILTER (way) AS velocity_forward_peak_rad_s,
        max(abs(v)) FILTER (back) AS velocity_backward_peak_rad_s,
        coalesce(sum((x - x0) * (f + f0) / 2) FILTER (way AND i > onset), 0) AS put_in,
        coalesce(sum((x - x0) * (f + f0) / 2) FILTER (back AND i > reversal), 0) AS taken_out,
        (max(x) FILTER (i = onset) - max(x) FILTER (i = "end"))
            * (max(f) FILTER (i = onset) + max(f) FILTER (i = "end")) / 2 AS chord,
        sqrt(avg((f - cmd) ** 2) FILTER (pressing)) AS force_rms_error_n,
        sum((b - a) * (t - t0)) FILTER ("either") AS wall_dwell_s,
        sum((f0 + (a + b) / 2 * (f - f0)) * (b - a) * (t - t0)) FILTER ("either") AS wall_impulse_n_s,
        $lever * sum((f0 + (a + b) / 2 * (f - f0)) * (b - a) * (x - x0)) FILTER ("either") AS wall_energy_j,
        min_by(v0 + passes * (v - v0), i) FILTER (past) AS wall_impact_velocity_rad_s,
        max(f) FILTER (past) AS wall_force_max_n,
        max(f) FILTER (past) - min_by(f0 + passes * (f - f0), i) FILTER (past) AS wall_force_rise_n,
        count(*) FILTER (x0 > $wall AND braked0 AND NOT braked) AS wall_brake_releases
    FROM parts GROUP BY k
)
SELECT k, participant, session, trial, return_force_n, motor_switches, brake_switches, actuator_switches,
       work_space_hits_low, work_space_hits_high,
       CASE WHEN end_s IS NOT NULL OR last_s - onset_s > $limit THEN last_s - onset_s <= $limit END AS protocol_in_time,
       theta_min_rad >= $low - $outside * ($high - $low) AND theta_max_rad <= $high + $outside * ($high - $low)
           AS protocol_inside,
       CASE WHEN by_motor_alone THEN bound END AS electrical_energy_max_j,
       CASE WHEN by_motor_alone AND commanded > 0 AND bound > 0 THEN commanded / bound END AS force_per_power_n_per_w,
       CASE WHEN walled THEN touches END AS wall_reached,
       CASE WHEN walled THEN contacts END AS wall_contacts,
       CASE WHEN touches THEN contacts - 1 END AS wall_rebounds,
       CASE WHEN touches THEN $lever * (theta_max_rad - $wall) END AS wall_depth_m,
       onset_s, reversal_s, end_s, end_s - onset_s AS duration_s, theta_max_rad,
       velocity_forward_peak_rad_s, velocity_backward_peak_rad_s, force_rms_error_n,
       CASE WHEN reversal_s > onset_s THEN forward / (reversal_s - onset_s) END AS velocity_forward_mean_rad_s,
       CASE WHEN last_s > reversal_s THEN backward / (last_s - reversal_s) END AS velocity_backward_mean_rad_s,
       CASE WHEN put_in > 0 AND goes_on THEN -taken_out / put_in END AS returned_energy_share,
       $lever * (put_in + taken_out + chord) AS loop_area_j,
       CASE WHEN touches THEN theta_max_rad - $wall END AS wall_past_max_rad,
       CASE WHEN touches THEN wall_dwell_s END AS wall_dwell_s,
       CASE WHEN touches THEN wall_impulse_n_s END AS wall_impulse_n_s,
       CASE WHEN touches THEN wall_energy_j END AS wall_energy_j,
       CASE WHEN touches THEN wall_impact_velocity_rad_s END AS wall_impact_velocity_rad_s,
       CASE WHEN touches THEN wall_force_max_n END AS wall_force_max_n,
       CASE WHEN touches THEN wall_force_rise_n END AS wall_force_rise_n,
       CASE WHEN touches THEN wall_brake_releases END AS wall_brake_releases
FROM (SELECT *, walled AND theta_max_rad > $wall AS touches FROM sums) JOIN arrivals USING (k);

-- Compression over decompression on a grid of angles that both reach: each branch has the samples that are farther
-- along than any before.
CREATE OR REPLACE TEMP TABLE there AS
WITH risen AS (
    SELECT k, i, x, f, max(x) OVER (PARTITION BY k ORDER BY i ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING) AS most
    FROM samples WHERE way
)
SELECT k, x, f, lag(x) OVER w AS x0, lag(f) OVER w AS f0 FROM risen WHERE most IS NULL OR x > most
WINDOW w AS (PARTITION BY k ORDER BY x);

CREATE OR REPLACE TEMP TABLE here AS
WITH fallen AS (
    SELECT k, i, x, f, min(x) OVER (PARTITION BY k ORDER BY i ROWS BETWEEN UNBOUNDED PRECEDING AND 1 PRECEDING) AS least
    FROM samples WHERE back
)
SELECT k, x, f, lag(x) OVER w AS x0, lag(f) OVER w AS f0 FROM fallen WHERE x < least
WINDOW w AS (PARTITION BY k ORDER BY x);

CREATE OR REPLACE TEMP TABLE discrepancy AS
WITH ends AS (
    SELECT k, greatest(min(t.x), any_value(h.a)) AS low, least(max(t.x), any_value(h.b)) AS high,
           max(t.x) - min(t.x) AS length, max(t.x) AS turned
    FROM there t JOIN (SELECT k, min(x) AS a, max(x) AS b FROM here GROUP BY k) h USING (k) GROUP BY k
), grid AS (
    SELECT k, j, turned,
           CASE WHEN j = $points - 1 THEN high ELSE least(low + (high - low) * (j / ($points - 1)), high) END AS theta
    FROM ends, range($points) AS r(j) WHERE high > low AND high - low >= $least_share * length
), gaps AS (
    SELECT g.k, j, theta, turned,
           CASE WHEN t.x = g.theta THEN t.f ELSE t.f0 + (g.theta - t.x0) / (t.x - t.x0) * (t.f - t.f0) END
           - CASE WHEN h.x = g.theta THEN h.f ELSE h.f0 + (g.theta - h.x0) / (h.x - h.x0) * (h.f - h.f0) END AS d
    FROM grid g ASOF JOIN there t ON g.k = t.k AND g.theta <= t.x ASOF JOIN here h ON g.k = h.k AND g.theta <= h.x
), steps AS (
    SELECT *, lag(theta) OVER w AS theta0, lag(d) OVER w AS d0 FROM gaps WINDOW w AS (PARTITION BY k ORDER BY j)
)
SELECT k, sum((theta - theta0) * (d + d0) / 2) / (max(theta) - min(theta)) AS discrepancy_user_mean_n,
       max(d) AS discrepancy_user_max_n,
       regr_intercept(d, theta - turned) FILTER (j >= $points - 1 - ($points - 1) // $step_window)
           AS discrepancy_user_step_n
FROM steps GROUP BY k;

-- The line of the compression, up to where its force saturates: the best of all divisions into line and plateau.
CREATE OR REPLACE TEMP TABLE press AS
WITH pressed AS (
    SELECT k, i, x - $rest AS u, f FROM samples WHERE pressing
), middles AS (
    SELECT k, avg(u) AS u_mean, avg(f) AS f_mean FROM pressed GROUP BY k
), centred AS (
    SELECT k, i, u, f, u_mean, u - u_mean AS a, f - f_mean AS b FROM pressed JOIN middles USING (k)
), running AS (
    SELECT *, row_number() OVER w AS m, count(*) OVER (PARTITION BY k) AS size, lead(a) OVER w AS follows,
           sum(a) OVER w AS sa, sum(b) OVER w AS sb,
           sum(a * a) OVER w AS aa, sum(a * b) OVER w AS ab, sum(b * b) OVER w AS bb,
           sum(b) OVER (PARTITION BY k) AS all_b, sum(b * b) OVER (PARTITION BY k) AS all_bb
    FROM centred WINDOW w AS (PARTITION BY k ORDER BY u, i ROWS BETWEEN UNBOUNDED PRECEDING AND CURRENT ROW)
), divided AS (
    SELECT *, (ab - sa * sb / m) / (aa - sa * sa / m) AS slope FROM running
)
SELECT k, u, f, m, size, a, follows, u_mean,
       ((all_b - sb) / (size - m) - (sb - slope * sa) / m) / slope AS meets,
       bb - sb * sb / m - slope * (ab - sa * sb / m) + all_bb - bb - (all_b - sb) ** 2 / (size - m) AS rss
FROM divided WHERE m < size UNION ALL
SELECT k, u, f, m, size, a, NULL, u_mean, NULL, NULL FROM divided WHERE m = size;

CREATE OR REPLACE TEMP TABLE stiffness AS
WITH best AS (
    SELECT k, arg_min(m, rss) AS division, arg_min(meets, rss) + any_value(u_mean) AS u_s, min(rss) AS rss FROM press
    WHERE m >= $least_samples AND size - m >= $least_samples AND a <= meets AND meets <= follows GROUP BY k
), judged AS (
    SELECT k, any_value(u_s) AS u_s, regr_slope(f, u) FILTER (m <= division) AS rise,
           regr_slope(f, u) FILTER (m > division) AS goes_on,
           max(u) - any_value(u_s) >= $least_span * (max(u) - min(u)) AS is_long,
           any_value(best.rss) <= $better * (regr_syy(f, u) - regr_sxy(f, u) ** 2 / regr_sxx(f, u)) AS is_better
    FROM press JOIN best USING (k) GROUP BY k
), saturated AS (
    SELECT k, u_s FROM judged WHERE is_long AND is_better AND rise > 0 AND goes_on < $flat * rise
)
SELECT k, regr_slope(f, u) FILTER (below) AS stiffness_n_per_rad,
       regr_slope(f, u) FILTER (below) - $stiffness AS stiffness_error_n_per_rad,
       regr_r2(f, u) FILTER (below) AS stiffness_r2, regr_intercept(f, u) FILTER (below) AS force_at_rest_n,
       count(*) FILTER (below) AS stiffness_samples, avg(f) FILTER (NOT below) AS saturation_force_n,
       $rest + any_value(u_s) AS saturation_theta_rad
FROM (SELECT *, u_s IS NULL OR u < u_s AS below FROM press LEFT JOIN saturated USING (k)) GROUP BY k;

-- Where a wall is passed: the line of the way in, the force's growth over the lever's way, the longest rest.
CREATE OR REPLACE TEMP TABLE wall AS
WITH touching AS (
    SELECT *, ($wall - x0) / (x - x0) AS passes FROM samples WHERE walled AND highest > $wall
), steps AS (
    SELECT k, x - lag(x) OVER (PARTITION BY k ORDER BY x) AS step FROM touching
), counts AS (
    SELECT k, coalesce(min(step) FILTER (step > $least_rad), 0) AS "count" FROM steps GROUP BY k
), places AS (
    SELECT k, min(i) FILTER (x = highest) AS deepest, any_value("count") AS "count", any_value(n) AS n,
           min_by(i, (-f, i)) FILTER (past) AS most, min(i) FILTER (past AND highest - x <= $same * "count") AS holds,
           max(f) FILTER (past) - min_by(f0 + passes * (f - f0), i) FILTER (past) AS grown
    FROM touching JOIN counts USING (k) GROUP BY k
), held AS (
    SELECT k, coalesce(min(i), any_value(places.n)) AS lets_go FROM places LEFT JOIN touching USING (k)
    WHERE i > holds AND NOT (past AND highest - x <= $same * "count") GROUP BY k
), sums AS (
    SELECT k, count(*) FILTER (past AND i <= deepest) AS way_in,
           regr_slope(f, x - $wall) FILTER (past AND i <= deepest) AS slope, any_value("count") AS "count",
           any_value(grown) AS grown, max(x) FILTER (i <= most) - $wall AS moved,
           max(f) FILTER (i >= holds AND i < coalesce(lets_go, places.n)) - max(f) FILTER (i = holds) AS held
    FROM touching JOIN places USING (k) LEFT JOIN held USING (k) GROUP BY k
), turns AS (
    SELECT k, i, t, still, CASE WHEN still = lag(still) OVER w THEN 0 ELSE 1 END AS turns
    FROM touching WINDOW w AS (PARTITION BY k ORDER BY i)
), runs AS (
    SELECT k, t, still, sum(turns) OVER (PARTITION BY k ORDER BY i ROWS BETWEEN UNBOUNDED PRECEDING AND CURRENT ROW) AS run
    FROM turns
), rests AS (
    SELECT k, coalesce(max(long) FILTER (still), 0) AS wall_still_s
    FROM (SELECT k, run, any_value(still) AS still, max(t) - min(t) AS long FROM runs GROUP BY k, run) GROUP BY k
)
SELECT k, CASE WHEN way_in >= 3 THEN slope END AS wall_stiffness_n_per_rad,
       CASE WHEN grown > 0 AND greatest(moved, "count") > 0 THEN grown / greatest(moved, "count") END
           AS wall_rigidity_n_per_rad,
       CASE WHEN grown > 0 AND greatest(moved, "count") > 0 THEN moved <= "count" END AS wall_rigidity_at_least,
       CASE WHEN held > 0 AND "count" > 0 THEN held / "count" END AS wall_hold_rigidity_min_n_per_rad, wall_still_s
FROM sums JOIN rests USING (k);

SELECT * EXCLUDE (k) REPLACE (CASE WHEN discrepancy_user_mean_n IS NOT NULL THEN loop_area_j END AS loop_area_j)
FROM scalars LEFT JOIN discrepancy USING (k) LEFT JOIN stiffness USING (k) LEFT JOIN wall USING (k);

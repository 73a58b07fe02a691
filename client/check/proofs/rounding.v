(* rounding: what is left between geometry.v and the lemmas of Gappa: how errors of directions go through turns and supports,
   sums of any magnitude, and the statements "accepted implies true". slacks.v has check.c's macros: script/prove writes it. *)
Require Import Reals Lra Psatz geometry slacks.
Open Scope R_scope.

Definition u := / 2 ^ 53.

(* ---- directions ---- *)

(* A turn that is off by T in each coordinate, of a direction d' that is off already. *)
Theorem turn_error : forall w v d d' c T, 0 <= T -> square w v <> 0 ->
  Rabs (x (sub c (turned w v d'))) <= T -> Rabs (y (sub c (turned w v d'))) <= T -> Rabs (z (sub c (turned w v d'))) <= T ->
  norm (sub c (turned w v d)) <= norm (sub d' d) + sqrt 3 * T.
Proof.
  intros w v d d' c T HT Hq Hx Hy Hz. pose proof (triangle_sub c (turned w v d') (turned w v d)).
  rewrite turned_linear, turned_norm in H by assumption. pose proof (norm_of_coordinates _ T HT Hx Hy Hz). lra.
Qed.
(* What a support changes by when the direction does, for a set within M of its origin. *)
Theorem support_lipschitz : forall (S : set) d d' h h' M, (forall p, S p -> norm p <= M) -> reaches S d h ->
  (exists p, S p /\ dot d' p = h') -> h' <= h + M * norm (sub d' d).
Proof.
  intros S d d' h h' M HM H (p & Hp & E). specialize (H p Hp). pose proof (cauchy_schwarz (sub d' d) p). specialize (HM p Hp).
  assert (dot d' p = dot d p + dot (sub d' d) p) by (unfold dot, sub; simpl; ring).
  pose proof (norm_pos (sub d' d)). nra.
Qed.
(* All in all, positions and points being within the square root of 3: after k turns a direction is off by k sqrt 3 T. *)
Definition through k T := sqrt 3 * (k * (sqrt 3 * T)).
Lemma through_is : forall k T, through k T = 3 * k * T.
Proof.
  intros k T. assert (S : sqrt 3 * sqrt 3 = 3) by (apply sqrt_sqrt; lra). unfold through.
  replace (sqrt 3 * (k * (sqrt 3 * T))) with (sqrt 3 * sqrt 3 * k * T) by ring. rewrite S; ring.
Qed.
Theorem turns_lo : forall T,
  through 1 T + through 2 T + through 3 T = 18 * T /\ (* three frames: position, child's position, core *)
  through 1 T + through 2 T = 9 * T /\                (* two frames *)
  through 3 T = 9 * T /\                              (* a plane along its computed normal, two turns: its position *)
  through 3 T + through 4 T + through 5 T = 36 * T /\ (* what is beside it *)
  through 2 T = 6 * T.                                (* and the way between them *)
Proof. intro T. rewrite !through_is. repeat split; ring. Qed.
Theorem frames_hi : forall T e0 e1 e2, 0 <= T ->
  sqrt 3 * (e0 + T) + sqrt 3 * (e1 + 4 * T) + sqrt 3 * (e2 + 8 * T) = sqrt 3 * (e0 + T + e1 + 4 * T + e2 + 8 * T).
Proof. intros; ring. Qed.

(* ---- accepted implies true ---- *)

(* r is what proven_gap returns, in units of the scale, g the gap that it computed: |...| <= as gap.gappa and gap_of_plane.gappa. *)
Theorem accepted_lo : forall A B D n ha hb g r last lo, signed_distance A B D -> 0 < norm n ->
  reaches A n ha -> reaches B (mul (-1) n) hb ->
  Rabs (g - (- ha - hb) / norm n) <= LO_SLACK - last -> Rabs (r - (g - LO_SLACK)) <= last -> lo <= r -> lo <= D.
Proof.
  intros A B D n ha hb g r last lo HD Hn HA HB Hg Hr Hlo.
  apply Rle_trans with ((- ha - hb) / norm n).
  - revert Hg Hr; unfold Rabs; destruct (Rcase_abs (g - (- ha - hb) / norm n)), (Rcase_abs (r - (g - LO_SLACK))); lra.
  - apply (axis_proves_lo A B D n); auto. intros a b Ha Hb. specialize (HA a Ha). specialize (HB b Hb).
    rewrite dot_mul_l in HB. rewrite dot_sub. replace ((- ha - hb) / norm n * norm n) with (- ha - hb) by (field; lra). lra.
Qed.
(* r is what proven_hi returns, sum what it computed: as proven_hi.gappa. *)
Theorem accepted_hi : forall A B SA SB D pa pb ea eb da db sum r last hi, signed_distance SA SB D ->
  near A pa ea -> near B pb eb ->
  (forall a, A a -> exists s, SA s /\ norm (sub a s) <= da) -> (forall b, B b -> exists s, SB s /\ norm (sub b s) <= db) ->
  Rabs (sum - (norm (sub pb pa) + (ea + da + (eb + db)))) <= HI_SLACK - last -> Rabs (r - (sum + HI_SLACK)) <= last -> r <= hi -> D <= hi.
Proof.
  intros A B SA SB D pa pb ea eb da db sum r last hi HD Ha Hb HA HB Hs Hr Hhi.
  pose proof (near_points_prove_hi A B SA SB D pa pb ea eb da db HD Ha Hb HA HB).
  revert Hs Hr; unfold Rabs; destruct (Rcase_abs (sum - _)), (Rcase_abs (r - _)); lra.
Qed.
(* What is allowed: the strict comparison of a rounded difference. Rounding never leads past a double (here: allowed). *)
Theorem allowed_is_allowed : forall claim r allowed d, (allowed <= claim - r -> allowed <= d) -> d < allowed -> claim - r < allowed.
Proof. intros; destruct (Rlt_dec (claim - r) allowed); auto. exfalso; apply Rnot_lt_le in n; auto; lra. Qed.
(* parts: f is the computed product, F exact; least what it is compared with, S |d| exact: as features.gappa. *)
Theorem accepted_product : forall f F least SD, (f - F) - (least - (SD + FEATURE_SLACK)) <= FEATURE_SLACK -> least < f -> SD < F.
Proof. intros; lra. Qed.

(* ---- sums of any magnitude: each rounding is off by u of the result, and by what underflow takes ---- *)

(* keeps_apart: T is the exact speed x time, or bend x time^2 / 4; `taken` comes of four roundings at most. *)
Theorem accepted_piece : forall first last margin T taken sum need diff size bound,
  0 <= T -> 0 <= taken -> T <= (1 + 5 * u) * taken + TINY / 4 ->
  Rabs (sum - (first + last)) <= u * (Rabs first + Rabs last) ->
  Rabs (need - (2 * margin + taken)) <= u * (2 * Rabs margin + taken) ->
  diff <= (1 + u) * (sum - need) ->
  (1 - 4 * u) * (Rabs first + Rabs last + (2 * Rabs margin + taken)) <= size ->
  (1 - 3 * u) * (RULE_SLACK * size + TINY) <= bound ->
  0 <= bound -> bound <= diff -> 2 * margin + T < first + last.
Proof.
  intros first last margin T taken sum need diff size bound. unfold u, RULE_SLACK, TINY.
  intros HT Htk H1 H2 H3 H4 H5 H6 H7 H8.
  pose proof (Rabs_pos first). pose proof (Rabs_pos last). pose proof (Rabs_pos margin).
  assert (Q1 : sum <= first + last + / 2 ^ 53 * (Rabs first + Rabs last)) by (revert H2; unfold Rabs at 1; destruct (Rcase_abs (sum - (first + last))); lra).
  assert (Q2 : 2 * margin + taken - / 2 ^ 53 * (2 * Rabs margin + taken) <= need) by (revert H3; unfold Rabs at 1; destruct (Rcase_abs (need - (2 * margin + taken))); lra).
  clear H2 H3. simpl in *. lra.
Qed.

(* length_at_most: of squares that underflow the coordinates are below 2^-500 (`small`); the rest is as lemma length has it. *)
Theorem tiny_length : forall a b c, Rabs a <= / 2 ^ 500 -> Rabs b <= / 2 ^ 500 -> Rabs c <= / 2 ^ 500 -> norm (V a b c) <= TINY.
Proof.
  intros a b c Ha Hb Hc. assert (P : 0 < 2 ^ 499) by (apply pow_lt; lra). unfold TINY.
  change (2 ^ 500) with (2 * 2 ^ 499) in *. set (p := 2 ^ 499) in *. clearbody p.
  assert (0 < / (2 * p)) by (apply Rinv_0_lt_compat; lra).
  pose proof (norm_of_coordinates (V a b c) (/ (2 * p)) ltac:(lra) Ha Hb Hc).
  assert (S : sqrt 3 <= 2).
  { apply Rle_trans with (sqrt 4); [apply sqrt_le_1_alt; lra|]. replace 4 with (2 * 2) by ring. rewrite sqrt_square; lra. }
  replace (1 / p) with (2 * / (2 * p)) by (field; lra).
  apply Rle_trans with (sqrt 3 * / (2 * p)); auto. apply Rmult_le_compat_r; lra.
Qed.
Theorem length_keeps : forall n v big small c r, v = add big small -> norm small <= TINY -> (1 - u) ^ n * norm big <= c ->
  (1 - u) * (c + TINY) <= r -> (1 - u) ^ S n * norm v <= r.
Proof.
  intros n v big small c r -> Hs Hc Hr. assert (U : 0 < u < 1) by (unfold u; simpl; lra).
  assert (P : 0 <= (1 - u) ^ n <= 1).
  { split; [apply pow_le; lra|]. assert (I : (1 - u) ^ n <= 1 ^ n) by (apply pow_incr; split; lra). now rewrite pow1 in I. }
  change ((1 - u) ^ S n) with ((1 - u) * (1 - u) ^ n). apply Rle_trans with ((1 - u) * (c + TINY)); auto.
  rewrite Rmult_assoc. apply Rmult_le_compat_l; [lra|]. pose proof (triangle big small). pose proof (norm_pos small).
  apply Rle_trans with ((1 - u) ^ n * (norm big + norm small)); [apply Rmult_le_compat_l; lra|].
  rewrite Rmult_plus_distr_l. apply Rplus_le_compat; auto. apply Rle_trans with (1 * norm small); [apply Rmult_le_compat_r; lra | lra].
Qed.

(* Sums of products of which none is negative: each step keeps at least 1 - u of what is exact. *)
Lemma bernoulli : forall n, 1 - INR n * u <= (1 - u) ^ n.
Proof.
  assert (0 < u < 1) by (unfold u; simpl; lra).
  induction n; [simpl; lra|]. rewrite S_INR. change ((1 - u) ^ S n) with ((1 - u) * (1 - u) ^ n).
  assert (N : 0 <= INR n) by apply pos_INR. assert (M : (1 - u) * (1 - INR n * u) <= (1 - u) * (1 - u) ^ n) by (apply Rmult_le_compat_l; lra). assert (0 <= INR n * (u * u)) by (apply Rmult_le_pos; [assumption | apply Rmult_le_pos; lra]). replace ((1 - u) * (1 - INR n * u)) with (1 - (INR n + 1) * u + INR n * (u * u)) in M by ring. lra.
Qed.
Theorem sums_keep : forall n c e k t, 0 <= e -> 0 <= t -> (1 - u) ^ n * e <= c -> (1 - u) ^ n * t <= k ->
  (1 - u) ^ S n * (e + t) <= (1 - u) * (c + k).
Proof.
  assert (0 < u < 1) by (unfold u; simpl; lra). intros n c e k t He Ht Hc Hk.
  change ((1 - u) ^ S n) with ((1 - u) * (1 - u) ^ n).
  replace ((1 - u) * (1 - u) ^ n * (e + t)) with ((1 - u) * ((1 - u) ^ n * e + (1 - u) ^ n * t)) by ring.
  apply Rmult_le_compat_l; lra.
Qed.
(* Of 256 products: 257 roundings, and the multiplication by 1 + SPEED_SLACK, which is a double. *)
Theorem accepted_speed : forall c e r, 0 <= e -> (1 - u) ^ 257 * e <= c -> (1 - u) * (c * (1 + SPEED_SLACK)) <= r -> e <= r.
Proof.
  intros c e r He Hc Hr. pose proof (bernoulli 257) as B. assert (0 < u < 1) by (unfold u; simpl; lra).
  replace (INR 257) with 257 in B by (rewrite INR_IZR_INZ; reflexivity). set (p := (1 - u) ^ 257) in *. clearbody p.
  assert (K : 1 <= (1 - u) * ((1 - 257 * u) * (1 + SPEED_SLACK))) by (unfold u, SPEED_SLACK; simpl; lra).
  assert (0 < SPEED_SLACK) by (unfold SPEED_SLACK; simpl; lra).
  assert ((1 - 257 * u) * e <= c) by nra.
  assert ((1 - u) * ((1 - 257 * u) * (1 + SPEED_SLACK)) * e <= (1 - u) * (c * (1 + SPEED_SLACK))).
  { replace ((1 - u) * ((1 - 257 * u) * (1 + SPEED_SLACK)) * e) with ((1 - u) * (1 + SPEED_SLACK) * ((1 - 257 * u) * e)) by ring.
    replace ((1 - u) * (c * (1 + SPEED_SLACK))) with ((1 - u) * (1 + SPEED_SLACK) * c) by ring.
    apply Rmult_le_compat_l; [apply Rmult_le_pos; lra | assumption]. }
  set (v := (1 - u) * ((1 - 257 * u) * (1 + SPEED_SLACK))) in *. clearbody v. assert (e <= v * e) by nra. lra.
Qed.

(* The last step of a sampled proof: blocks that are balls make every loop between
   the corners fall from tick to tick. *)
From Coq Require Import ZArith QArith.
From mathcomp Require Import all_ssreflect all_algebra ssrZ zify ring.
From formal Require Export numbers forms.
From formal Require Import integers definite.
Set Implicit Arguments. Unset Strict Implicit. Unset Printing Implicit Defensive.
Import Order.TTheory GRing.Theory Num.Theory.
Local Open Scope ring_scope.

(* A ball: the matrices that differ from middle / d by a map of norm radius / d. *)
Record ball := Ball { middle : seq (seq Z); radius : Z }.

Definition least (b : ball) : entries := fun i j =>
  Z.sub (Z.add (at_ (middle b) i j) (at_ (middle b) j i))
        (if i == j then Z.mul (Zpos 2) (radius b) else Z0).
Definition ball_shown N (b : ball) (w : witness) := shown N w (memo N N (least b)).

Section Meaning.
Variable C : numClosedFieldType.
Implicit Types s t r : C.

Definition is_real n m (A : 'M[C]_(n, m)) := map_mx conjC A = A.
Definition dot n (x y : 'rV[C]_n) : C := sesqui 1%:M x y.

(* The norm of d X - middle is at most the radius. *)
Definition within N (d : Z) (b : ball) (X : 'M[C]_N) := forall x y,
  `|sesqui (phi C d *: X - mx C N N (at_ (middle b))) x y| *+ 2
  <= phi C (radius b) * (dot x x + dot y y).

Lemma sesquiE n (A : 'M[C]_n) x y : sesqui A x y = dot (x *m A) y.
Proof. by rewrite /dot /sesqui mulmx1. Qed.
Lemma sesqui_real n (A : 'M[C]_n) x y : is_real A -> sesqui A x y = dot x (y *m A^T).
Proof.
move=> real_A; rewrite /dot /sesqui mulmx1 /adj map_mxM trmx_mul -map_trmx real_A.
by rewrite trmxK mulmxA.
Qed.
Lemma dotC n (x y : 'rV[C]_n) : dot y x = (dot x y)^*.
Proof.
rewrite /dot /sesqui !mulmx1 !mxE rmorph_sum; apply: eq_bigr => i _.
by rewrite !mxE rmorphM conjCK mulrC.
Qed.
Lemma dot_ge0 n (x : 'rV[C]_n) : 0 <= dot x x.
Proof.
rewrite /dot /sesqui !mulmx1 !mxE; apply: sumr_ge0 => i _.
by rewrite !mxE mul_conjC_ge0.
Qed.
Lemma Re_dot n (x y : 'rV[C]_n) : 'Re (dot y x) = 'Re (dot x y).
Proof. by rewrite dotC Re_conj. Qed.
Lemma Re_self n (x : 'rV[C]_n) : 'Re (dot x x) = dot x x.
Proof. by apply/Creal_ReP; rewrite ger0_real ?dot_ge0. Qed.
Lemma Re_one n (x : 'rV[C]_n) : 'Re (herm 1%:M x) = dot x x. Proof. exact: Re_self. Qed.
Lemma real_mx N m g : is_real (mx C N m g).
Proof. by apply/matrixP => i j; rewrite !mxE phi_conj. Qed.
Lemma real_real N m (a : numbers) : is_real (real C N m a).
Proof.
apply/matrixP => i j; rewrite !mxE; apply/conj_Creal.
by rewrite /phiQ rpred_div // /phi realz.
Qed.

Lemma sesquiD n (A B : 'M[C]_n) x y : sesqui (A + B) x y = sesqui A x y + sesqui B x y.
Proof. by rewrite /sesqui mulmxDr mulmxDl mxE. Qed.
Lemma sesquiZ n a (A : 'M[C]_n) x y : sesqui (a *: A) x y = a * sesqui A x y.
Proof. by rewrite /sesqui -scalemxAr -scalemxAl mxE. Qed.
Lemma sesquiB n (A B : 'M[C]_n) x y : sesqui (A - B) x y = sesqui A x y - sesqui B x y.
Proof. by rewrite -scaleN1r sesquiD sesquiZ mulN1r. Qed.
Lemma real_tr n m (A : 'M[C]_(n, m)) : is_real A -> is_real A^T.
Proof. by move=> real_A; rewrite /is_real -map_trmx real_A. Qed.
Lemma herm_tr n (A : 'M[C]_n) x : is_real A -> herm A^T x = (herm A x)^*.
Proof.
move=> real_A; rewrite /herm [in LHS]sesqui_real ?trmxK; last exact: real_tr.
by rewrite [dot x _]dotC -sesquiE.
Qed.

(* A ball that Rocq computes to be positive encloses positive forms alone. *)
Theorem ball_sound N d b w (X : 'M[C]_N) x : Z.ltb 0 d -> ball_shown N b w ->
  within d b X -> x != 0 -> 0 < 'Re (herm X x).
Proof.
move=> d0 sh inside x0; have {sh} := shown_sound sh x0.
set m := mx C N N (at_ (middle b)); set e := phi C (radius b); rewrite mx_memo.
have -> : mx C N N (least b) = m + m^T - (e *+ 2) *: 1%:M.
  apply/matrixP => i j; rewrite !mxE /least phiB phiD -[i == j]val_eqE; congr (_ + _ - _).
  rewrite [X in phi C (if X then _ else _)](_ : _ = (val i == val j)) //.
  case: (val i == val j); last by rewrite phi0 mulr0.
  by rewrite phiM mulr1 -[Zpos 2]/(Z.add 1 1) phiD phi1 mulrDl mul1r mulr2n.
rewrite /herm sesquiB sesquiD sesquiZ -!/(herm _ _) herm_tr; last exact: real_mx.
rewrite twice_Re => pos.
have {inside} := inside x x; rewrite -/m -/e sesquiB sesquiZ -!/(herm _ _) -!/(dot _ _).
set h := dot x x; set y := herm m x; set z := herm X x => near.
have {near} : `|phi C d * z - y| <= e * h.
  by move: near; rewrite -mulr2n mulrnAr ler_pmuln2r.
have d_real : phi C d \is Num.real by rewrite /phi realz.
have -> : ('Re z > 0) = ('Re (phi C d * z) > 0) by rewrite ReMl // pmulr_rgt0 ?phi_gt0.
move=> near; rewrite -[phi C d * z](subrK y) raddfD /=.
have low := leif_normC_Re_Creal (phi C d * z - y).
have : - (e * h) <= 'Re (phi C d * z - y).
  apply: (real_lerNnormlW (Creal_Re _)).
  by apply: le_trans near; rewrite low.
have : e * h < 'Re y.
  rewrite -(ltr_pmuln2r (isT : (0 < 2)%N)) -subr_gt0 -mulrnAl.
  by rewrite -['Re y *+ 2]mulr_natl.
by move=> hi lo; rewrite addrC -(subrr (e * h)); apply: ltr_le_add.
Qed.

(* ---- The loop: rows x, and F acts as x F'. *)
Definition tick_block n s t r (P F G W : 'M[C]_n) : 'M[C]_(n + n) :=
  block_mx (r ^+ 2 *: P - s *: W) (F^T *m G^T) (G *m F)
    (G + G^T - P - t *: (G *m G^T)).
Definition plain_block n s t r (F W : 'M[C]_n) : 'M[C]_n :=
  r ^+ 2 *: 1%:M - (1 + s) *: (F^T *m F) - (1 + t) *: W.

(* W is above D'D, and s t = 1 where there is a D. *)
Definition bends n s t (D W : 'M[C]_n) := [/\ 0 <= s, 0 <= t,
  (s * t == 1) || (D == 0) & forall x, dot (x *m D^T) (x *m D^T) <= 'Re (herm W x)].

Lemma square n s t (a b : 'rV[C]_n) : 0 <= s -> 0 <= t -> (s * t == 1) || (a == 0) ->
  'Re (dot a b) *+ 2 <= s * dot a a + t * dot b b.
Proof.
move=> s0 t0 /orP[/eqP st|/eqP->]; last first.
  by rewrite /dot !sesqui0l raddf0 mul0rn mulr0 add0r mulr_ge0 ?dot_ge0.
have spos : 0 < s.
  by rewrite lt_def s0 andbT; apply: contra_eqN st => /eqP->; rewrite mul0r eq_sym oner_eq0.
rewrite -(ler_pmul2l spos) [X in _ <= X]mulrDr (mulrA s t) st mul1r -subr_ge0.
have := dot_ge0 (s *: a - b); rewrite /dot -scaleN1r sesquiDl !sesquiDr !sesquiZl !sesquiZr.
rewrite -!/(dot _ _) rmorphN rmorph1 (conj_Creal (ger0_real s0)).
have -> : dot b a = 'Re (dot a b) *+ 2 - dot a b.
  by rewrite -['Re _ *+ 2]mulr_natl -twice_Re -dotC addrC addKr.
by congr (_ <= _); rewrite mulr2n; ring.
Qed.

Lemma herm_block n (A B E F : 'M[C]_n) x y :
  herm (block_mx A B E F) (row_mx x (- y))
  = herm A x - sesqui B x y - sesqui E y x + herm F y.
Proof.
rewrite /herm /sesqui; have -> : adj (row_mx x (- y)) = col_mx (adj x) (- adj y).
  by rewrite /adj map_row_mx tr_row_mx map_mxN [(- _)^T]linearN.
rewrite mul_row_block mul_row_col !mulmxDl !mulNmx !mulmxN !mxE; ring.
Qed.

Lemma block_value n s t r (P F G W : 'M[C]_n) x y : r \is Num.real -> 0 <= s -> 0 <= t ->
  is_real F -> is_real G -> let b := y *m G in let p := x *m F^T in
  'Re (herm (tick_block s t r P F G W) (row_mx x (- y)))
  = r ^+ 2 * 'Re (herm P x) - s * 'Re (herm W x) - 'Re (herm P y) - t * dot b b
    + 'Re (dot (y - p) b) *+ 2.
Proof.
move=> r_real s0 t0 rF rG b p; rewrite herm_block.
have -> : sesqui (F^T *m G^T) x y = dot p b.
  by rewrite sesquiE mulmxA -sesquiE sesqui_real ?trmxK //; exact: real_tr.
have -> : sesqui (G *m F) y x = dot b p by rewrite sesquiE mulmxA -sesquiE sesqui_real.
rewrite /herm !sesquiB !sesquiD !sesquiZ -!/(herm _ _).
have -> : herm G y = dot b y by rewrite /herm sesquiE.
have -> : herm G^T y = dot y b by rewrite /herm sesqui_real ?trmxK //; exact: real_tr.
have -> : herm (G *m G^T) y = dot b b.
  by rewrite /herm sesquiE mulmxA -sesquiE sesqui_real ?trmxK //; exact: real_tr.
rewrite /dot -scaleN1r sesquiDl sesquiZl mulN1r -!/(dot _ _).
rewrite !raddfD /= !raddfN /= (Re_dot p b) (Re_dot y b).
rewrite (ReMl (rpredX 2 r_real)) !ReMl ?ger0_real // Re_self mulr2n; ring.
Qed.

(* The form P falls by r^2 at each tick of F, whose poles are within r of zero. *)
Definition contracts n r (P F : 'M[C]_n) : Prop := forall x, x != 0 ->
  'Re (herm P (x *m F^T)) < r ^+ 2 * 'Re (herm P x)
  /\ forall lam, x *m F^T = lam *: x -> `|lam| < r.

Lemma contracts_where n r (P F : 'M[C]_n) : 0 < r -> (forall x, x != 0 ->
    'Re (herm P (x *m F^T)) < r ^+ 2 * 'Re (herm P x) /\ 0 < 'Re (herm P x)) ->
  contracts r P F.
Proof.
move=> r0 both x x0; have [fall pos] := both x x0; split=> // lam xF.
move: fall; rewrite xF /herm sesquiZl sesquiZr mulrA -normCK ReMl; last first.
  by rewrite rpredX // ger0_real // normr_ge0.
by rewrite ltr_pmul2r // ltr_pexpn2r // ?nnegrE ?normr_ge0 // ltW.
Qed.

Section Corners.
Variables (n k : nat) (s t r : C) (F P : 'I_k -> 'M[C]_n) (G W D : 'M[C]_n).
Variable w : 'I_k -> C.
Hypothesis w_ge0 : forall i, 0 <= w i.
Hypothesis w_sum : \sum_i w i = 1.
Hypothesis bend : bends s t D W.
Hypothesis r_positive : 0 < r.
Let r_real : r \is Num.real. Proof. exact: gtr0_real. Qed.
Definition loop : 'M[C]_n := \sum_i w i *: F i + D.
Definition between : 'M[C]_n := \sum_i w i *: P i.

Lemma some_weight (f : 'I_k -> C) : (forall i, 0 < f i) -> 0 < \sum_i w i * f i.
Proof.
move=> pos; have /existsP[i wi] : [exists i, w i != 0].
  apply/contraT => /existsPn all0; move: w_sum; rewrite big1 => [/eqP|i _].
    by rewrite eq_sym oner_eq0.
  by apply/eqP; have := all0 i; rewrite negbK.
rewrite (bigD1 i) //=; apply: ltr_paddr; last by rewrite mulr_gt0 // lt_def wi w_ge0.
by apply: sumr_ge0 => j _; rewrite mulr_ge0 // ltW.
Qed.
Lemma Re_weighted (f : 'I_k -> C) : \sum_i w i * 'Re (f i) = 'Re (\sum_i w i * f i).
Proof. by rewrite raddf_sum; apply: eq_bigr => i _ /=; rewrite ReMl ?ger0_real. Qed.
Lemma herm_between x : 'Re (herm between x) = \sum_i w i * 'Re (herm (P i) x).
Proof.
have big0 : sesqui (0 : 'M[C]_n) x x = 0 by rewrite /sesqui mulmx0 mul0mx mxE.
rewrite /herm (big_morph _ (fun A B => sesquiD A B x x) big0) Re_weighted.
by congr (Re _); apply: eq_bigr => i _; rewrite sesquiZ.
Qed.
Lemma bent (x : 'rV[C]_n) : x *m loop^T - \sum_i w i *: (x *m (F i)^T) = x *m D^T.
Proof.
rewrite /loop [(_ + _)^T]raddfD /= mulmxDr raddf_sum /= mulmx_sumr.
rewrite [X in X + _ - _](eq_bigr (fun i => w i *: (x *m (F i)^T))) => [|i _].
  by rewrite addrAC subrr add0r.
by rewrite linearZ /= scalemxAr.
Qed.

Section WithP.
Hypothesis F_real : forall i, is_real (F i).
Hypothesis G_real : is_real G.
Hypothesis positive : forall i z, z != 0 ->
  0 < 'Re (herm (tick_block s t r (P i) (F i) G W) z).

(* What the mean of the corners' P measures falls from tick to tick. *)
Theorem falls x : x != 0 ->
  'Re (herm between (x *m loop^T)) < r ^+ 2 * 'Re (herm between x).
Proof.
move=> x0; set y := x *m loop^T; pose b := y *m G; case: bend => s0 t0 st below_W.
have z0 : row_mx x (- y) != 0.
  by apply: contraNneq x0 => /(congr1 lsubmx); rewrite row_mxKl linear0 => ->.
have := some_weight (fun i => positive i z0).
have -> : \sum_i w i * 'Re (herm (tick_block s t r (P i) (F i) G W) (row_mx x (- y)))
  = r ^+ 2 * 'Re (herm between x) - s * 'Re (herm W x) - 'Re (herm between y)
    - t * dot b b + 'Re (dot (x *m D^T) b) *+ 2.
  have -> : dot (x *m D^T) b = \sum_i w i * dot (y - x *m (F i)^T) b.
    rewrite -bent -/y -{1}[y]scale1r -w_sum scaler_suml -sumrB /dot.
    rewrite -sesqui_suml; congr (sesqui _ _ _); apply: eq_bigr => i _; by rewrite scalerBr.
  rewrite -Re_weighted !herm_between -[s * _]mul1r -[t * _]mul1r -w_sum.
  rewrite !mulr_suml mulr_sumr -sumrMnl -!sumrB -big_split; apply: eq_bigr => i _ /=.
  by rewrite block_value // -/b !mulr2n; ring.
have st0 : (s * t == 1) || (x *m D^T == 0).
  by case/orP: st => [->//|/eqP->]; rewrite trmx0 mulmx0 eqxx orbT.
have := square b s0 t0 st0; have := ler_wpmul2l s0 (below_W x).
set a := dot (x *m D^T) _; set hW := 'Re (herm W x); set hy := 'Re (herm between y).
set hx := _ * 'Re _ => le1 le2 pos; rewrite -subr_gt0; apply: lt_le_trans pos _.
rewrite -subr_ge0; have := ler_add le1 le2; rewrite -subr_ge0.
by congr (_ <= _); rewrite !mulr2n; ring.
Qed.
Theorem with_P_contracts : contracts r between loop.
Proof.
apply: contracts_where r_positive _ => x x0; split; first exact: falls.
case: bend => s0 t0 _ below_W.
have z0 : row_mx x (- 0) != 0 :> 'rV[C]_(n + n).
  by apply: contraNneq x0 => /(congr1 lsubmx); rewrite row_mxKl linear0 => ->.
have := some_weight (fun i => positive i z0).
rewrite (eq_bigr (fun i => r ^+ 2 * (w i * 'Re (herm (P i) x)) - w i * (s * 'Re (herm W x)))).
  rewrite sumrB -mulr_sumr -mulr_suml w_sum mul1r -herm_between subr_gt0 => lt_W.
  rewrite -(pmulr_rgt0 _ (exprn_gt0 2 r_positive)); apply: le_lt_trans lt_W.
  by rewrite mulr_ge0 //; apply: le_trans (below_W x); exact: dot_ge0.
move=> i _; rewrite block_value // mul0mx /dot !sesqui0r /herm sesqui0l raddf0 mul0rn.
by rewrite mulr0; ring.
Qed.
End WithP.

Section Plain.
Hypothesis positive : forall i z, z != 0 ->
  0 < 'Re (herm (plain_block s t r (F i) W) z).
Hypothesis F_real : forall i, is_real (F i).

Lemma plain_value i x : 'Re (herm (plain_block s t r (F i) W) x)
  = r ^+ 2 * dot x x - (1 + s) * dot (x *m (F i)^T) (x *m (F i)^T)
    - (1 + t) * 'Re (herm W x).
Proof.
case: bend => s0 t0 _ _; rewrite /herm !sesquiB !sesquiZ -!/(herm _ _) -/(dot _ _).
have -> : herm ((F i)^T *m F i) x = dot (x *m (F i)^T) (x *m (F i)^T).
  by rewrite /herm sesquiE mulmxA -sesquiE sesqui_real.
rewrite !raddfB /= (ReMl (rpredX 2 r_real)) !ReMl ?ger0_real ?addr_ge0 ?ler01 //.
by rewrite Re_one Re_self.
Qed.

Theorem plain_contracts : contracts r 1%:M loop.
Proof.
apply: contracts_where r_positive _ => x x0.
rewrite !Re_one; pose p i := x *m (F i)^T; pose m := \sum_i w i *: p i; pose a := x *m D^T.
case: bend => s0 t0 st below_W.
have -> : x *m loop^T = m + a by rewrite /m /a -(bent x) addrC subrK.
have := some_weight (fun i => positive i x0).
rewrite (eq_bigr (fun i => w i * (r ^+ 2 * dot x x - (1 + t) * 'Re (herm W x))
    - (1 + s) * (w i * dot (p i) (p i)))); last first.
  by move=> i _; rewrite plain_value -/(p i); ring.
rewrite sumrB -mulr_suml -mulr_sumr w_sum mul1r subr_gt0 ltr_subr_addl => pos.
have jensen : dot m m <= \sum_i w i * dot (p i) (p i).
  have : 0 <= \sum_i w i * dot (p i - m) (p i - m).
    by apply: sumr_ge0 => i _; rewrite mulr_ge0 ?dot_ge0.
  have first : \sum_i w i * dot (p i) m = dot m m by rewrite -sesqui_suml.
  have second : \sum_i w i * dot m (p i) = dot m m.
    rewrite {2}/m /dot sesqui_sumr; apply: eq_bigr => i _.
    by rewrite conj_Creal // ger0_real.
  rewrite (eq_bigr (fun i => w i * dot (p i) (p i) - w i * dot (p i) m
      - w i * dot m (p i) + w i * dot m m)); last first.
    move=> i _; rewrite /dot -scaleN1r sesquiDl !sesquiDr !sesquiZl !sesquiZr.
    by rewrite rmorphN rmorph1; ring.
  rewrite big_split /= !sumrB first second -mulr_suml w_sum mul1r.
  by rewrite subrK subr_ge0.
have ts : (t * s == 1) || (a == 0).
  by case/orP: st => [|/eqP D0]; rewrite mulrC ?/a ?D0 ?trmx0 ?mulmx0 ?eqxx ?orbT // => ->.
have sq := square m t0 s0 ts.
have -> : dot (m + a) (m + a) = dot m m + 'Re (dot a m) *+ 2 + dot a a.
  rewrite /dot sesquiDl !sesquiDr -!/(dot _ _) -['Re _ *+ 2]mulr_natl -twice_Re -dotC.
  by ring.
have upper : dot m m + 'Re (dot a m) *+ 2 + dot a a
    <= (1 + t) * 'Re (herm W x) + (1 + s) * \sum_i w i * dot (p i) (p i).
  have A : (1 + s) * dot m m <= (1 + s) * \sum_i w i * dot (p i) (p i).
    by rewrite ler_wpmul2l // addr_ge0 ?ler01.
  have B : (1 + t) * dot a a <= (1 + t) * 'Re (herm W x).
    by rewrite ler_wpmul2l ?addr_ge0 ?ler01 //; exact: below_W.
  rewrite -subr_ge0; have := ler_add sq (ler_add A B); rewrite -subr_ge0.
  by congr (_ <= _); ring.
split; first exact: le_lt_trans upper pos.
rewrite -(pmulr_rgt0 _ (exprn_gt0 2 r_positive)); apply: le_lt_trans pos.
rewrite addr_ge0 // mulr_ge0 ?addr_ge0 ?ler01 //.
  by apply: le_trans (below_W x); exact: dot_ge0.
by apply: sumr_ge0 => i _; rewrite mulr_ge0 ?dot_ge0.
Qed.
End Plain.
End Corners.
End Meaning.

(* ---- What gen.py writes: a box of clocks of a cell of plants, its rate, its share,
   and its corners with their balls, whose numbers are over d. *)
Record corner := Corner { corner_P : numbers; corner_ball : ball }.
Definition no_ball := Ball [::] Z0.
Definition no_corner := Corner [::] no_ball.
Definition balls_hold N (rate share : Q) d (bs : seq ball) (ws : seq witness) :=
  [&& Z.ltb 0 d, ~~ Qle_bool rate zero, Qle_bool zero share
    & below (size bs) (fun i => ball_shown N (nth no_ball bs i) (nth no_witness ws i))].

(* F_i are the loop's matrices at the corners, and D is what a loop between them has
   beside their mean: x' D' D x <= x' W x. A share of zero belongs to a box without D. *)
Definition corners_of (C : numClosedFieldType) n k (share : Q) (w : 'I_k -> C)
    (F : 'I_k -> 'M[C]_n) (D W : 'M[C]_n) :=
  [/\ forall i, 0 <= w i, \sum_i w i = 1, forall i, is_real (F i),
    phiQ C share = 0 -> D = 0
  & forall x, dot (x *m D^T) (x *m D^T) <= 'Re (herm W x)].
Definition with_P_contract n (rate share : Q) (G : numbers) d (cs : seq corner) :=
  forall (C : numClosedFieldType) (w : 'I_(size cs) -> C)
    (F : 'I_(size cs) -> 'M[C]_n) (D W : 'M[C]_n),
  corners_of share w F D W ->
  let P (i : 'I_(size cs)) := real C n n (corner_P (nth no_corner cs i)) in
  let r := phiQ C rate in let s := phiQ C share in
  (forall i : 'I_(size cs), within d (corner_ball (nth no_corner cs i))
     (tick_block s s^-1 r (P i) (F i) (real C n n G) W)) ->
  contracts r (\sum_i w i *: P i) (\sum_i w i *: F i + D).
Definition plain_contract n (rate share : Q) d (bs : seq ball) :=
  forall (C : numClosedFieldType) (w : 'I_(size bs) -> C)
    (F : 'I_(size bs) -> 'M[C]_n) (D W : 'M[C]_n),
  corners_of share w F D W -> let r := phiQ C rate in let s := phiQ C share in
  (forall i : 'I_(size bs), within d (nth no_ball bs i) (plain_block s s^-1 r (F i) W)) ->
  contracts r 1%:M (\sum_i w i *: F i + D).

Section Sound.
Variable C : numClosedFieldType.
Lemma phiQ_pos q : ~~ Qle_bool q zero -> 0 < phiQ C q.
Proof. by move=> /(phiQ_lt C); rewrite phiQ0. Qed.
Lemma bends_of n k share (w : 'I_k -> C) F (D W : 'M[C]_n) : Qle_bool zero share ->
  corners_of share w F D W -> bends (phiQ C share) (phiQ C share)^-1 D W.
Proof.
move=> /(phiQ_le C); rewrite phiQ0 => s0 [_ _ _ none below_W]; split=> //.
  by rewrite invr_ge0.
have [share0|nz] := eqVneq (phiQ C share) 0; last by rewrite divff ?eqxx.
by rewrite none ?eqxx ?orbT.
Qed.
End Sound.

Theorem with_P_sound n rate share G d cs ws :
  balls_hold (n + n) rate share d [seq corner_ball c | c <- cs] ws ->
  with_P_contract n rate share G d cs.
Proof.
move=> /and4P[d0 r0 s0 /belowP shown_] C w F D W ok P r s inside.
have [w0 w1 rF _ _] := ok.
apply: (with_P_contracts w0 w1 (bends_of s0 ok) (phiQ_pos C r0) rF (real_real C n n G)).
move=> i z z0; apply: (ball_sound d0 _ (inside i) z0).
by have := shown_ i; rewrite size_map (nth_map no_corner) //; apply.
Qed.

Theorem plain_sound n rate share d bs ws : balls_hold n rate share d bs ws ->
  plain_contract n rate share d bs.
Proof.
move=> /and4P[d0 r0 s0 /belowP shown_] C w F D W ok r s inside.
have [w0 w1 rF _ _] := ok.
apply: (plain_contracts w0 w1 (bends_of s0 ok) (phiQ_pos C r0)) => // i z z0.
by apply: (ball_sound d0 (shown_ i (ltn_ord i)) (inside i) z0).
Qed.
